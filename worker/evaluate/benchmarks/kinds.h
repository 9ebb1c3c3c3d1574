// One function for each file of this folder: it adds the kinds of benchmark that the file knows.
#pragma once

#include <vector>

#include "worker/evaluate/benchmark.h"

namespace parallax {

void AddMiddlebury2014(std::vector<BenchmarkKind>& kinds);
void AddMiddlebury2014Sets(std::vector<BenchmarkKind>& kinds);
void AddMiddlebury2021(std::vector<BenchmarkKind>& kinds);
void AddEth3d(std::vector<BenchmarkKind>& kinds);
void AddKitti(std::vector<BenchmarkKind>& kinds);
void AddBooster(std::vector<BenchmarkKind>& kinds);
void AddDrivingStereo(std::vector<BenchmarkKind>& kinds);
void AddShipped(std::vector<BenchmarkKind>& kinds);
void AddPairFolder(std::vector<BenchmarkKind>& kinds);
void AddPairList(std::vector<BenchmarkKind>& kinds);
void AddArchive(std::vector<BenchmarkKind>& kinds);

}  // namespace parallax
