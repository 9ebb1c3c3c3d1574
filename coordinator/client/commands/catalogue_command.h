#pragma once

#include "coordinator/client/command.h"

namespace parallax::client {

void RegisterCatalogue(Registry& registry);

}  // namespace parallax::client
