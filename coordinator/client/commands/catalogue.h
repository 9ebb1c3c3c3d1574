#pragma once

#include "coordinator/client/commands/command.h"

namespace parallax::client {

void RegisterCatalogue(Registry& registry);

}  // namespace parallax::client
