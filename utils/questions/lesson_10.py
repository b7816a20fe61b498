"""Small cases for questions about students' own code."""

from utils.questions.clustering_cases import clustering_cases

CASES = {"euclidean_clustering_accelerated": clustering_cases("euclidean_clustering_accelerated")}
