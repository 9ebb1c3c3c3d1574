// The table of routes, walked: each is closed to strangers and to those without the role, and none
// is forgotten.
#include <regex>
#include <set>

#include "coordinator/http/api.h"
#include "coordinator/rpc/access.h"
#include "tests/coordinator/http/http_fixture.h"

namespace parallax {
namespace {

// The table itself, as the server registers it.
class RoutesTest : public HttpTest {
 protected:
  RoutesTest()
      : sampler_("", Clock::System(), *queue_, *server_),
        pictures_(nullptr),
        sessions_(Clock::System()),
        reader_(*PageReader::Open(options_.db_path, queue_->kinds())),
        parts_{*queue_, *server_, sampler_, *reader_, pictures_, sessions_, "", "c", false},
        routes_(ApiRoutes(parts_)) {}

  StatusSampler sampler_;
  Pictures pictures_;
  Sessions sessions_;
  std::unique_ptr<PageReader> reader_;
  ApiParts parts_;
  std::vector<WebRoute> routes_;
};

int StatusFor(const Browser& client, const WebRoute& route) {
  if (std::string_view(route.method) == "POST") {
    const auto answer = HttpTest::Post(client, route.example);
    return answer ? answer->status : -1;
  }
  // Streams have no end: their beginning is enough.
  const auto answer =
      client.Get(route.example, {}, [&](std::string_view) { return !route.events; });
  return answer ? answer->status : -1;
}

TEST_F(RoutesTest, EachIsMatchedByItsExampleAndListedOnce) {
  std::set<std::string> seen;
  for (const WebRoute& route : routes_) {
    EXPECT_TRUE(std::regex_match(route.example, std::regex(route.pattern))) << route.pattern;
    EXPECT_TRUE(seen.insert(std::string(route.method) + route.pattern).second) << route.pattern;
    if (route.access == WebAccess::kRoles) {
      EXPECT_TRUE(RolesOf(std::string("/parallax.v1.Coordinator/") + route.rpc))
          << route.pattern << ": there is no RPC " << route.rpc;
    }
  }
  EXPECT_GT(routes_.size(), 20u);
}

TEST_F(RoutesTest, OnlyHealthAndSigningInAreOpenToStrangers) {
  std::vector<std::string> open, known;
  for (const WebRoute& route : routes_) {
    if (route.access == WebAccess::kAnybody) open.push_back(route.pattern);
    if (route.access == WebAccess::kKnown) known.push_back(route.pattern);
  }
  EXPECT_THAT(known,
              testing::UnorderedElementsAre("/api/v1/me", "/api/v1/links", "/api/v1/session/end"))
      << "whoever is known may ask who they are; all else is by role";
  EXPECT_THAT(open, testing::UnorderedElementsAre("/healthz", "/api/v1/session"));
}

TEST_F(RoutesTest, EachRefusesStrangersAndThoseWithoutTheRole) {
  Submit();
  ServeTls();
  const auto stranger = TlsClient(""), worker = TlsClient("worker-pool"),
             board = TlsClient("read-only-board"), olga = TlsClient("operator-olga");
  for (const WebRoute& route : routes_) {
    if (route.access == WebAccess::kAnybody) continue;
    const std::string name = std::string(route.method) + " " + route.example;
    EXPECT_EQ(StatusFor(*stranger, route), 401) << name;
    if (route.access == WebAccess::kKnown) continue;
    EXPECT_EQ(StatusFor(*worker, route), 403) << name;
    const bool changes = std::string_view(route.method) == "POST";
    const bool for_operators = changes || std::string_view(route.rpc) == "ListAudit";
    if (for_operators) {
      EXPECT_EQ(StatusFor(*board, route), 403) << name;
    } else {
      EXPECT_NE(StatusFor(*board, route), 403) << name;
    }
    const int status = StatusFor(*olga, route);
    EXPECT_NE(status, 401) << name;
    EXPECT_NE(status, 403) << name;
  }
}

TEST_F(RoutesTest, PathsThatAreNoRouteTellStrangersNothing) {
  ServeTls();
  const auto stranger = TlsClient("");
  for (const char* path :
       {"/api/v1/nowhere", "/api/v1/studies/1/nowhere", "/nowhere", "/metrics"}) {
    EXPECT_EQ(stranger->Get(path)->status, 401) << path;
  }
  EXPECT_EQ(TlsClient("read-only-board")->Get("/api/v1/nowhere")->status, 404);
}

}  // namespace
}  // namespace parallax
