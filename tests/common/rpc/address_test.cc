#include "common/rpc/address.h"

#include <gtest/gtest.h>

namespace parallax {
namespace {

TEST(RpcAddress, ReadsWhatItWritesAndKnowsWhatIsLocal) {
  const struct {
    const char* text;
    bool local;
    bool is_unix;
    int port;
  } cases[] = {
      {"127.0.0.1:7070", true, false, 7070},     {"127.8.9.10:1", true, false, 1},
      {"localhost:0", true, false, 0},           {"[::1]:65535", true, false, 65535},
      {"0.0.0.0:7070", false, false, 7070},      {"farm-1.example.org:7070", false, false, 7070},
      {"[::]:7070", false, false, 7070},         {"127.example.org:80", false, false, 80},
      {"127.0.0:80", false, false, 80},          {"127.evil.com:80", false, false, 80},
      {"127.0.0.999:80", false, false, 80},      {"127.0.0.1.:80", false, false, 80},
      {"LOCALHOST:80", true, false, 80},         {"localhost.evil.com:80", false, false, 80},
      {"[::ffff:1.2.3.4]:80", false, false, 80}, {"unix:/run/parallax.sock", true, true, 0},
  };
  for (const auto& row : cases) {
    const auto address = ParseRpcAddress(row.text);
    ASSERT_TRUE(address.ok()) << row.text << " " << address.status();
    EXPECT_EQ(address->ToString(), row.text);
    EXPECT_EQ(address->is_local(), row.local) << row.text;
    EXPECT_EQ(address->is_unix(), row.is_unix) << row.text;
    EXPECT_EQ(address->port, row.port) << row.text;
  }
}

TEST(RpcAddress, RefusesWhatIsNoAddressAndSaysWhatIsWanted) {
  const std::string long_path = "unix:/" + std::string(107, 'x');
  for (const std::string text : {"", "7070", "localhost", ":7070", "localhost:", "localhost:65536",
                                 "localhost:7070x", "localhost:-1", "::1:7070", "a b:1", "a/b:1",
                                 "unix:", "unix:relative.sock", long_path.c_str()}) {
    const auto address = ParseRpcAddress(text);
    ASSERT_FALSE(address.ok()) << text;
    EXPECT_EQ(address.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_NE(address.status().ToString().find("HOST:PORT"), std::string::npos);
  }
}

}  // namespace
}  // namespace parallax
