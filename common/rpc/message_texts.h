// The texts of a message from another program, all in one place: to cut them before they are sent,
// and to make them printable before a person sees them.
#pragma once

#include <functional>
#include <string>

namespace google::protobuf {
class Message;
}

namespace parallax {

// Calls `change` with each text of `message`, nested ones included, and the name of its field, and
// keeps what it leaves.
// Keys of maps, bytes, and `source_yaml`, which is a file, are not touched.
void ChangeTexts(google::protobuf::Message* message,
                 const std::function<void(const std::string& field, std::string* text)>& change);

}  // namespace parallax
