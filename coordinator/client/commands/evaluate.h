#pragma once

#include "coordinator/client/commands/command.h"

namespace parallax::client {

void RegisterEvaluate(Registry& registry);
void RegisterPredict(Registry& registry);
void RegisterTable(Registry& registry);

}  // namespace parallax::client
