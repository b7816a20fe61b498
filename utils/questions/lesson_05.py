"""Small calls of the functions of lesson 05, for questions about students' own code."""

from utils.questions.clustering_cases import clustering_cases

CASES = {"euclidean_clustering": clustering_cases("euclidean_clustering")}
