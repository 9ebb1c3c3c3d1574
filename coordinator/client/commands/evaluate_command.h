#pragma once

#include "coordinator/client/command.h"

namespace parallax::client {

void RegisterCurate(Registry& registry);
void RegisterEvaluate(Registry& registry);
void RegisterPredict(Registry& registry);
void RegisterTable(Registry& registry);

}  // namespace parallax::client
