#include "coordinator/client/preview/preview_page.h"

#include <atomic>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/base/names.h"
#include "common/base/system/secret.h"
#include "common/rpc/address.h"
#include "coordinator/http/page_replies.h"
#include "coordinator/http/server/credentials.h"
#include "coordinator/http/server/web_server.h"

namespace parallax::client {
namespace {

constexpr int kMostWatchers = 32;
constexpr double kLook_s = 0.3, kSign_s = 15;  // Streams say so often that they live.
constexpr char kPagePath[] = "/preview.html";

class PreviewPageImpl final : public PreviewPage {
 public:
  explicit PreviewPageImpl(std::string file) : file_(std::move(file)) {}
  ~PreviewPageImpl() override {
    if (server_) server_->Stop();
  }

  absl::Status Listen(const std::string& listen) {
    ASSIGN_OR_RETURN(const RpcAddress address, ParseRpcAddress(listen));
    if (address.is_unix() || !address.is_local()) {
      return InvalidArgument(
          "--page-listen: {} is no address of this machine alone, allowed are HOST:PORT of its "
          "loopback, such as 127.0.0.1:8080",
          Quoted(listen));
    }
    ASSIGN_OR_RETURN(const std::string secret, NewSecret());
    root_ = "/" + secret + "/";
    WebServerOptions options{.listen = address, .headers = PageHeaders()};
    ASSIGN_OR_RETURN(server_, WebServer::Bind(options));
    server_->Start([this](const ServerRequest& request) { return Answer(request); },
                   [](std::string_view) { return false; });
    return absl::OkStatus();
  }

  std::string link() const override { return "http://" + server_->address().ToString() + root_; }

  void Tell(PreviewState state) override {
    const std::lock_guard lock(mutex_);
    state_ = std::move(state);
    ++told_;
  }

  void Show(std::string sheet_png) override {
    const std::lock_guard lock(mutex_);
    sheet_png_ = std::move(sheet_png);
    ++sheets_;
    ++told_;
  }

 private:
  ServerReply Answer(const ServerRequest& request) {
    // Another site may have pointed a name of its own here.
    const std::optional<std::string> host = HostIn(request.Header("host"));
    if (!host || !IsLoopbackHost(*host)) {
      return {.reply = ErrorReply(PermissionDenied("this port is for names of this machine only"))};
    }
    const bool known = request.method == "GET" && request.path.starts_with(root_);
    const std::string name = known ? request.path.substr(root_.size()) : "";
    if (known && name.empty()) {
      ServerRequest page = request;
      page.path = kPagePath;
      return *PageFileReply(page);
    }
    if (name == "sheet.png") return Sheet();
    if (name == "events") return Events(request);
    if (const auto file = PageFileReply(request)) return *file;
    return {.reply = ErrorReply(NotFound("there is no {}", Quoted(request.path)))};
  }

  ServerReply Sheet() {
    const std::lock_guard lock(mutex_);
    if (sheets_ == 0) return {.reply = ErrorReply(NotFound("no sheet is made yet"))};
    ServerReply reply;
    reply.reply.type = "image/png";
    reply.reply.headers = {{"Cache-Control", "no-store"}};
    reply.reply.body = sheet_png_;
    return reply;
  }

  ServerReply Events(const ServerRequest& request) {
    // The stream's place, for as long as somebody has a copy.
    const std::shared_ptr<void> place(nullptr, [this](void*) { watchers_.fetch_sub(1); });
    if (watchers_.fetch_add(1) >= kMostWatchers || !request.know()) {
      return {.reply = ErrorReply(Unavailable("too many watch already"))};
    }
    struct Stream {
      int64_t told = -1;
      double silent_s = 0;
    };
    ServerReply reply;
    reply.every_s = kLook_s;
    reply.events = [this, place, stream = std::make_shared<Stream>()] {
      return std::optional<std::string>(EventText(stream->told, stream->silent_s));
    };
    return reply;
  }

  std::string EventText(int64_t& told, double& silent_s) {
    const std::lock_guard lock(mutex_);
    silent_s += kLook_s;
    if (told == told_ && silent_s < kSign_s) return "";
    silent_s = 0;
    if (told == told_) return ": still here\n\n";
    told = told_;
    const nlohmann::ordered_json json = {{"file", file_},
                                         {"making", state_.making},
                                         {"text", state_.text},
                                         {"error", state_.error},
                                         {"sheet", sheets_}};
    return "event: preview\ndata: " +
           json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n\n";
  }

  const std::string file_;
  std::string root_;  // "/SECRET/"; constant once it serves.
  std::mutex mutex_;
  PreviewState state_;  // Guarded by mutex_, as the next three.
  std::string sheet_png_;
  int64_t sheets_ = 0;  // Shown so far.
  int64_t told_ = 0;    // Grows with each change.
  std::atomic<int> watchers_ = 0;
  std::unique_ptr<WebServer> server_;  // Last: it stops before what its handlers use goes.
};

}  // namespace

absl::StatusOr<std::unique_ptr<PreviewPage>> PreviewPage::Start(const std::string& listen,
                                                                const std::string& file) {
  auto page = std::make_unique<PreviewPageImpl>(file);
  RETURN_IF_ERROR(page->Listen(listen));
  return std::unique_ptr<PreviewPage>(std::move(page));
}

}  // namespace parallax::client
