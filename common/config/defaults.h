// Inner part of common/config: the defaults of fields, from their rules (FieldRule in
// config.proto).
#pragma once

#include <google/protobuf/message.h>

namespace parallax::config_internal {

// Sets every absent field to the default of its rule, in nested messages too. A group without any
// default stays absent. Ends the process by std::logic_error if a rule's own default is not valid.
// Thread-safe.
void ApplyDefaults(google::protobuf::Message* message);

}  // namespace parallax::config_internal
