// PCL's clustering and a detector built from PCL's parts, as functions for Python's ctypes.

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <pcl/filters/crop_box.h>
#include <pcl/filters/extract_indices.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/extract_clusters.h>
#include <pcl/segmentation/sac_segmentation.h>

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

std::vector<pcl::PointIndices> clusters(const Cloud::Ptr& cloud, double radius, int least) {
    std::vector<pcl::PointIndices> found;
    if (cloud->empty()) return found;
    auto tree = std::make_shared<pcl::search::KdTree<pcl::PointXYZ>>();
    tree->setInputCloud(cloud);
    pcl::EuclideanClusterExtraction<pcl::PointXYZ> extraction;
    extraction.setClusterTolerance(radius);
    extraction.setMinClusterSize(least);
    extraction.setMaxClusterSize(std::numeric_limits<int>::max());
    extraction.setSearchMethod(tree);
    extraction.setInputCloud(cloud);
    extraction.extract(found);
    return found;
}

Cloud::Ptr crop(const Cloud::Ptr& cloud, Eigen::Vector4f low, Eigen::Vector4f high, bool outside) {
    auto kept = std::make_shared<Cloud>();
    pcl::CropBox<pcl::PointXYZ> box;
    box.setMin(low);
    box.setMax(high);
    box.setNegative(outside);
    box.setInputCloud(cloud);
    box.filter(*kept);
    return kept;
}

// The steps and parameters of lesson 12; of each box, the angle and the extents.
std::vector<std::array<float, 7>> detect(const Cloud::Ptr& cloud, double radius) {
    auto points = crop(cloud, {-15, -7, -3, 1}, {35, 9, 1, 1}, false);
    points = crop(points, {-1.5, -1.7, -1, 1}, {2.6, 1.7, -0.4, 1}, true);

    auto low = std::make_shared<Cloud>();
    for (const auto& point : *points)
        if (point.z < -1.2f) low->push_back(point);
    pcl::ModelCoefficients road;
    pcl::PointIndices near;
    if (low->size() >= 3) {
        pcl::SACSegmentation<pcl::PointXYZ> segmentation;
        segmentation.setModelType(pcl::SACMODEL_PLANE);
        segmentation.setMethodType(pcl::SAC_RANSAC);
        segmentation.setMaxIterations(50);
        segmentation.setProbability(1.0 - 1e-12);  // all rounds, as ours
        segmentation.setDistanceThreshold(0.2);
        segmentation.setOptimizeCoefficients(true);
        segmentation.setInputCloud(low);
        segmentation.segment(near, road);
    }
    auto standing = std::make_shared<Cloud>();
    for (const auto& p : *points) {
        const auto& r = road.values;
        if (r.empty() || std::abs(r[0] * p.x + r[1] * p.y + r[2] * p.z + r[3]) > 0.3f)
            standing->push_back(p);
    }

    auto thinned = std::make_shared<Cloud>();
    pcl::VoxelGrid<pcl::PointXYZ> voxels;
    voxels.setLeafSize(0.2f, 0.2f, 0.2f);
    voxels.setInputCloud(standing);
    voxels.filter(*thinned);

    std::vector<std::array<float, 7>> boxes;
    const float most = std::numeric_limits<float>::max();
    for (const auto& cluster : clusters(thinned, radius, 10)) {
        std::array<float, 7> snuggest{};
        float least = most;
        for (int turn = 0; turn < 90; ++turn) {
            const float angle = turn * float(M_PI) / 180, cosine = std::cos(angle), sine = std::sin(angle);
            std::array<float, 7> box{angle, most, -most, most, -most, most, -most};
            for (int row : cluster.indices) {
                const auto& p = (*thinned)[row];
                const float values[] = {p.x * cosine + p.y * sine, p.y * cosine - p.x * sine, p.z};
                for (int axis = 0; axis < 3; ++axis) {
                    box[1 + 2 * axis] = std::min(box[1 + 2 * axis], values[axis]);
                    box[2 + 2 * axis] = std::max(box[2 + 2 * axis], values[axis]);
                }
            }
            const float area = (box[2] - box[1]) * (box[4] - box[3]);
            if (area < least) least = area, snuggest = box;
        }
        boxes.push_back(snuggest);
    }
    return boxes;
}

extern "C" {

// Return a cloud that is never freed: the process of a benchmark loads few of them.
Cloud::Ptr* load_cloud(const float* xyz, long count) {
    auto cloud = std::make_shared<Cloud>();
    for (long row = 0; row < count; ++row)
        cloud->push_back({xyz[3 * row], xyz[3 * row + 1], xyz[3 * row + 2]});
    return new Cloud::Ptr(cloud);
}

void label_clusters(const Cloud::Ptr* cloud, double radius, std::int32_t* labels) {
    std::int32_t label = 0;
    for (const auto& cluster : clusters(*cloud, radius, 1)) {
        ++label;
        for (int row : cluster.indices) labels[row] = label;
    }
}

long count_boxes(const Cloud::Ptr* cloud, double radius) { return detect(*cloud, radius).size(); }
}
