// PCL's clustering and a detector made of PCL's parts, to be timed beside ours.
//
//     pcl_peer cluster|detect POINTS RADIUS ANSWER
//
// POINTS holds x y z as float32. For each line on standard input the work is done once and its
// seconds are printed. ANSWER receives, after the first time, what came out: labels as int32, or
// the number of boxes.

#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iostream>
#include <limits>
#include <string>
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

int main(int count, char** arguments) {
    if (count != 5) {
        std::cerr << "pcl_peer cluster|detect POINTS RADIUS ANSWER\n";
        return 2;
    }
    const std::string work = arguments[1];
    const double radius = std::stod(arguments[3]);
    auto cloud = std::make_shared<Cloud>();
    std::ifstream file(arguments[2], std::ios::binary);
    for (float xyz[3]; file.read(reinterpret_cast<char*>(xyz), sizeof xyz);)
        cloud->push_back({xyz[0], xyz[1], xyz[2]});

    bool first = true;
    for (std::string line; std::getline(std::cin, line); first = false) {
        const auto begin = std::chrono::steady_clock::now();
        std::vector<pcl::PointIndices> groups;
        std::size_t boxes = 0;
        if (work == "cluster") groups = clusters(cloud, radius, 1);
        else boxes = detect(cloud, radius).size();
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
        if (first) {
            std::ofstream answer(arguments[4], std::ios::binary);
            if (work == "detect") answer << boxes;
            std::vector<std::int32_t> labels(cloud->size(), 0);
            for (std::size_t group = 0; group < groups.size(); ++group)
                for (int row : groups[group].indices) labels[row] = std::int32_t(group) + 1;
            if (work == "cluster")
                answer.write(reinterpret_cast<char*>(labels.data()), 4 * std::streamsize(labels.size()));
        }
        std::cout << seconds.count() << std::endl;
    }
}
