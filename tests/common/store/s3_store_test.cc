// Against a real S3 server (moto, from deploy/setup.sh) that recomputes every signature.
#include "common/store/s3_store.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <sstream>
#include <thread>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/store/local_store.h"
#include "tests/common/store/store_conformance.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

// One for all tests of this program. Ends with our end of its standard input.
class S3Server {
 public:
  static S3Server& Get() {
    static S3Server server;
    return server;
  }
  const std::string& endpoint() const { return endpoint_; }
  const std::string& access_key() const { return access_key_; }
  const std::string& secret_key() const { return secret_key_; }

 private:
  S3Server() {
    int in[2], out[2];
    if (pipe(in) != 0 || pipe(out) != 0) abort();
    pid_ = fork();
    if (pid_ == 0) {
      dup2(in[0], 0);
      dup2(out[1], 1);
      for (int fd : {in[0], in[1], out[0], out[1]}) close(fd);
      // Its log, a line a request, is not ours.
      if (std::freopen("/dev/null", "w", stderr) == nullptr) _exit(126);
      execl(PARALLAX_S3_TEST_PYTHON, PARALLAX_S3_TEST_PYTHON, PARALLAX_S3_TEST_SERVER, nullptr);
      _exit(127);
    }
    close(in[0]);
    close(out[1]);
    input_ = in[1];
    std::FILE* lines = fdopen(out[0], "r");
    char line[512] = "";
    if (std::fgets(line, sizeof line, lines) == nullptr) {
      ADD_FAILURE() << "no S3 server: run deploy/setup.sh, which installs " PARALLAX_S3_TEST_PYTHON;
    }
    std::fclose(lines);
    std::string port;
    std::istringstream(line) >> port >> access_key_ >> secret_key_;
    endpoint_ = "http://127.0.0.1:" + port;
  }
  ~S3Server() {
    close(input_);
    kill(pid_, SIGTERM);
    waitpid(pid_, nullptr, 0);
  }

  pid_t pid_ = -1;
  int input_ = -1;
  std::string endpoint_, access_key_, secret_key_;
};

S3Options Options() {
  static std::atomic<int> counter{0};
  S3Options options;
  options.bucket = "results";
  options.prefix = "test more/" + std::to_string(++counter);
  options.endpoint = S3Server::Get().endpoint();
  options.region = "us-east-1";
  options.path_style = true;
  options.access_key = S3Server::Get().access_key();
  options.secret_key = S3Server::Get().secret_key();
  options.first_pause = std::chrono::milliseconds(1);
  return options;
}

std::unique_ptr<Store> MakeS3Store() {
  auto store = OpenS3Store(Options());
  EXPECT_TRUE(store.ok()) << store.status();
  return std::move(*store);
}

INSTANTIATE_TEST_SUITE_P(S3, StoreConformance, ::testing::Values(&MakeS3Store));

TEST(S3Store, LargeFilesGoInParts) {
  S3Options options = Options();
  options.part_bytes = 5 << 20;
  const auto store = *OpenS3Store(options);
  std::string bytes(static_cast<size_t>(11 << 20), '\0');
  for (size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * 2654435761u >> 13);
  ASSERT_TRUE(store->Put("k/large", bytes).ok());
  const auto back = store->Get("k/large");
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(Sha256Hex(*back), Sha256Hex(bytes));
  EXPECT_EQ(*store->GetPiece("k/large", (5 << 20) - 3, 6),
            bytes.substr(static_cast<size_t>((5 << 20) - 3), 6));
}

int64_t PeakMemory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return int64_t{1024} * usage.ru_maxrss;
}

TEST(S3Store, FilesAreSentFromDiskWholeOrInParts) {
  const std::string path = testing::TempDir() + "s3-large-" + std::to_string(getpid());
  constexpr int64_t kBytes = 20 << 20;
  {
    std::ofstream file(path, std::ios::binary);
    std::string row(1 << 16, '\0');
    for (int64_t at = 0; at < kBytes; at += static_cast<int64_t>(row.size())) {
      for (size_t i = 0; i < row.size(); i += 16) row[i] = static_cast<char>((at >> 16) + i);
      file << row;
    }
  }
  const StoreFile facts{kBytes, *Sha256HexOfFile(path)};
  for (const int64_t part_bytes : {int64_t{64} << 20, int64_t{8} << 20}) {
    S3Options options = Options();
    options.part_bytes = part_bytes;
    const auto store = *OpenS3Store(options);
    const int64_t before = PeakMemory();
    const absl::Status put = store->PutFile("k/large", path, facts, false);
    ASSERT_TRUE(put.ok()) << put;
    EXPECT_LT(PeakMemory() - before, kBytes / 2) << "it is never in memory as a whole";
    Sha256 hash;
    for (int64_t at = 0; at < kBytes; at += 4 << 20) {
      hash.Update(*store->GetPiece("k/large", at, 4 << 20));
    }
    EXPECT_EQ(HexOf(hash.Finish()), facts.sha256);
    EXPECT_EQ(store->PutFile("k/other", path, {kBytes, std::string(64, 'a')}, false).code(),
              absl::StatusCode::kDataLoss);
  }
  fs::remove(path);
}

TEST(S3Store, AWrongKeyIsToldAtOnce) {
  S3Options options = Options();
  options.secret_key = "wrong";
  const absl::Status status = OpenS3Store(options).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kPermissionDenied) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("SignatureDoesNotMatch"));
}

TEST(S3Store, AMissingBucketIsToldAtOnce) {
  S3Options options = Options();
  options.bucket = "nowhere";
  const absl::Status status = OpenS3Store(options).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("NoSuchBucket"));
}

// Reads a request with its body.
std::string ReadRequest(int peer) {
  std::string request;
  char piece[4096];
  for (ssize_t size; (size = read(peer, piece, sizeof piece)) > 0;) {
    request.append(piece, static_cast<size_t>(size));
    const size_t end = request.find("\r\n\r\n");
    if (end == std::string::npos) continue;
    const std::string name = "Content-Length: ";
    const size_t field = request.find(name);
    const size_t body = field < end ? std::stoul(request.substr(field + name.size())) : 0;
    if (request.size() >= end + 4 + body) break;
  }
  return request;
}

// Answers the first requests with what it is told, each on its own connection: a status, and a body
// after a line break. All answers have the lines `headers`, each with "\r\n" before it.
class MoodyServer {
 public:
  explicit MoodyServer(std::vector<std::string> answers, std::string headers = "")
      : answers_(std::move(answers)), headers_(std::move(headers)) {
    fd_ = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(bind(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(listen(fd_, 8), 0);
    socklen_t size = sizeof address;
    getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size);
    endpoint_ = "http://127.0.0.1:" + std::to_string(ntohs(address.sin_port));
    thread_ = std::thread([this] {
      for (const std::string& answer : answers_) {
        const int peer = accept(fd_, nullptr, nullptr);
        if (peer < 0) return;
        ++answered;  // Before the client can know: it may look at once.
        const std::string request = answer.empty() ? "" : ReadRequest(peer);
        if (!request.empty()) {
          {
            const std::lock_guard lock(mu_);
            requests_.push_back(request);
          }
          const size_t status = std::min(answer.find('\n'), answer.size());
          const std::string body = answer.substr(std::min(status + 1, answer.size()));
          const std::string whole = "HTTP/1.1 " + answer.substr(0, status) + headers_ +
                                    "\r\nContent-Length: " + std::to_string(body.size()) +
                                    "\r\nConnection: close\r\n\r\n" + body;
          (void)!write(peer, whole.data(), whole.size());
        }
        close(peer);  // Without an answer: a broken connection.
      }
    });
  }
  ~MoodyServer() {
    shutdown(fd_, SHUT_RDWR);
    thread_.join();
    close(fd_);
  }
  const std::string& endpoint() const { return endpoint_; }
  // Returns the requests that were read.
  std::vector<std::string> requests() {
    const std::lock_guard lock(mu_);
    return requests_;
  }
  std::atomic<int> answered = 0;

 private:
  const std::vector<std::string> answers_;
  const std::string headers_;
  std::mutex mu_;
  std::vector<std::string> requests_;  // Guarded by mu_.
  int fd_;
  std::string endpoint_;
  std::thread thread_;
};

// The answer of a bucket that Parallax has used before.
const std::string kMarkerAnswer = "200 OK\n" + StoreMarkerText("an id");

TEST(S3Store, BusyAndBrokenServersAreAskedAgain) {
  MoodyServer server({"503 Slow Down", "429 Too Many", "", "500 Oops", "200 OK", kMarkerAnswer});
  S3Options options = Options();
  options.endpoint = server.endpoint();
  EXPECT_TRUE(OpenS3Store(options, {.read_only = true}).ok());
  EXPECT_EQ(server.answered, 6);
}

TEST(S3Store, AListWithForeignKeysIsRefused) {
  MoodyServer server({"200 OK", kMarkerAnswer,
                      "200 OK\n<ListBucketResult><Contents><Key>far</Key><Size>3</Size></Contents>"
                      "</ListBucketResult>"});
  S3Options options = Options();
  options.endpoint = server.endpoint();
  options.prefix = "farm/of/mine";
  const auto store = OpenS3Store(options, {.read_only = true});
  ASSERT_TRUE(store.ok()) << store.status();
  const absl::Status status = (*store)->List("").status();
  EXPECT_TRUE(absl::IsDataLoss(status)) << status;
  EXPECT_THAT(status.message(), testing::HasSubstr("\"far\", which does not begin with \"farm"));
}

TEST(S3Store, MarksOfFoldersAreNoFiles) {
  MoodyServer server(
      {"200 OK", kMarkerAnswer,
       "200 OK\n<ListBucketResult><Contents><Key>farm/</Key><Size>0</Size></Contents>"
       "<Contents><Key>farm/content/</Key><Size>0</Size></Contents>"
       "<Contents><Key>farm/content/ab</Key><Size>3</Size></Contents>"
       "</ListBucketResult>"});
  S3Options options = Options();
  options.endpoint = server.endpoint();
  options.prefix = "farm";
  const auto store = OpenS3Store(options, {.read_only = true});
  ASSERT_TRUE(store.ok()) << store.status();
  const auto entries = (*store)->List("");
  ASSERT_TRUE(entries.ok()) << entries.status();
  ASSERT_EQ(entries->size(), 1u);
  EXPECT_EQ((*entries)[0].path, "content/ab");
}

// Ceph continues after a key, which it writes as XML; some servers encode no keys.
TEST(S3Store, AListGoesOnFromTokensAndKeysThatXmlWritesOtherwise) {
  MoodyServer server(
      {"200 OK", kMarkerAnswer,
       "200 OK\n<ListBucketResult><IsTruncated>true</IsTruncated>"
       "<NextContinuationToken>a&amp;b/c++/1</NextContinuationToken>"
       "<Contents><Key>a&#38;b/c++/1</Key><Size>3</Size></Contents></ListBucketResult>",
       "200 OK\n<ListBucketResult><EncodingType>url</EncodingType><IsTruncated>false</IsTruncated>"
       "<Contents><Key>a%26b/c%2B%2B/x+2</Key><Size>3</Size></Contents></ListBucketResult>"});
  S3Options options = Options();
  options.endpoint = server.endpoint();
  options.prefix = "a&b/c++";
  const auto store = OpenS3Store(options, {.read_only = true});
  ASSERT_TRUE(store.ok()) << store.status();
  const auto entries = (*store)->List("");
  ASSERT_TRUE(entries.ok()) << entries.status();
  ASSERT_EQ(entries->size(), 2u);
  EXPECT_EQ((*entries)[0].path, "1");
  EXPECT_EQ((*entries)[1].path, "x 2");
  ASSERT_EQ(server.requests().size(), 4u);
  EXPECT_THAT(server.requests()[3], HasSubstr("continuation-token=a%26b%2Fc%2B%2B%2F1&"));
}

TEST(S3Store, AListThatIsCutOffWithoutAContinuationIsRefused) {
  MoodyServer server({"200 OK", kMarkerAnswer,
                      "200 OK\n<ListBucketResult><IsTruncated>true</IsTruncated><Contents><Key>k/1"
                      "</Key><Size>3</Size></Contents></ListBucketResult>"});
  S3Options options = Options();
  options.endpoint = server.endpoint();
  options.prefix = "k";
  const auto store = OpenS3Store(options, {.read_only = true});
  ASSERT_TRUE(store.ok()) << store.status();
  const absl::Status status = (*store)->List("").status();
  EXPECT_TRUE(absl::IsUnimplemented(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("wanted is a server that knows"));
}

TEST(S3Store, APieceIsCutFromAnAnswerThatIsTheWholeFile) {
  const std::string whole = "200 OK\n0123456789";
  MoodyServer server({"200 OK", kMarkerAnswer, whole, whole, whole});
  S3Options options = Options();
  options.endpoint = server.endpoint();
  const auto store = OpenS3Store(options, {.read_only = true});
  ASSERT_TRUE(store.ok()) << store.status();
  EXPECT_EQ(*(*store)->GetPiece("k/a", 0, 4), "0123");
  EXPECT_EQ(*(*store)->GetPiece("k/a", 8, 100), "89");
  EXPECT_EQ(*(*store)->GetPiece("k/a", 10, 5), "");
}

TEST(S3Store, ABodyThatCameTooSlowlyIsSentAgainAndIsNoMistake) {
  const std::string slow = "400 Bad Request\n<Error><Code>RequestTimeout</Code></Error>";
  MoodyServer server({"200 OK", kMarkerAnswer, slow, "200 OK", slow, slow});
  S3Options options = Options();
  options.endpoint = server.endpoint();
  options.tries = 2;
  const auto store = OpenS3Store(options, {.read_only = true});
  ASSERT_TRUE(store.ok()) << store.status();
  EXPECT_TRUE((*store)->Put("a/b", "x").ok());
  EXPECT_TRUE(absl::IsUnavailable((*store)->Put("a/b", "x")));
  EXPECT_EQ(server.answered, 6);
}

TEST(S3Store, AnUploadInPartsWhoseLastAnswerIsLostIsComplete) {
  const std::string bytes = "12345678";
  const std::string gone = "404 Not Found\n<Error><Code>NoSuchUpload</Code></Error>";
  const std::vector<std::string> answers = {
      "200 OK", kMarkerAnswer, "200 OK\n<UploadId>u</UploadId>",
      "200 OK", "200 OK",      "" /* of the last request */,
      gone,     "200 OK"};
  MoodyServer server(answers, "\r\nETag: \"t\"\r\nx-amz-meta-sha256: " + Sha256Hex(bytes));
  S3Options options = Options();
  options.endpoint = server.endpoint();
  options.part_bytes = 4;
  const auto store = OpenS3Store(options, {.read_only = true});
  ASSERT_TRUE(store.ok()) << store.status();
  const absl::Status put = (*store)->Put("a/b", bytes);
  EXPECT_TRUE(put.ok()) << put;
  EXPECT_EQ(server.answered, 8);
}

TEST(S3Store, ABucketOfAnotherRegionIsTold) {
  MoodyServer server(
      {"301 Moved Permanently\n<Error><Code>PermanentRedirect</Code>"
       "<Endpoint>results.s3.eu-west-1.amazonaws.com</Endpoint></Error>"});
  S3Options options = Options();
  options.endpoint = server.endpoint();
  const absl::Status status = OpenS3Store(options).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("the endpoint is results.s3.eu-west-1.amazonaws.com; set region"));
}

TEST(S3Store, AServerThatStaysAwayIsUnavailableAndARefusalIsNotRepeated) {
  MoodyServer server({"503 Slow Down", "503 Slow Down", "403 Forbidden"});
  S3Options options = Options();
  options.endpoint = server.endpoint();
  options.tries = 2;
  EXPECT_TRUE(absl::IsUnavailable(OpenS3Store(options, {.read_only = true}).status()));
  EXPECT_TRUE(absl::IsPermissionDenied(OpenS3Store(options, {.read_only = true}).status()));
  EXPECT_EQ(server.answered, 3);
}

TEST(S3Store, ACommandGivesCredentialsAndFreshOnesWhenTheServerRefusesThem) {
  S3Options options = Options();
  const std::string calls = testing::TempDir() + "credentials-" + std::to_string(getpid());
  std::filesystem::remove(calls);
  // The first ones are unknown to the server, as those that ended are.
  options.credentials_command = fmt::format(
      R"(echo x >> {0}; key={1}; [ $(wc -l < {0}) -gt 1 ] || key=gone
         printf '{{"AccessKeyId": "%s", "SecretAccessKey": "{2}"}}' "$key")",
      calls, options.access_key, options.secret_key);
  options.access_key = options.secret_key = "";
  const auto store = OpenS3Store(options);
  ASSERT_TRUE(store.ok()) << store.status();
  ASSERT_TRUE((*store)->Put("a/b", "x").ok());
  EXPECT_EQ(*(*store)->Get("a/b"), "x");
  EXPECT_EQ(std::filesystem::file_size(calls), 4u) << "asked twice in all";
  std::filesystem::remove(calls);
  options.credentials_command = "echo no role here >&2; exit 3";
  const absl::Status refused = OpenS3Store(options).status();
  EXPECT_TRUE(absl::IsPermissionDenied(refused));
  EXPECT_THAT(std::string(refused.message()), HasSubstr("exit status 3: no role here"));
}

class S3UriTest : public testing::Test {
 protected:
  S3UriTest() {
    setenv("AWS_ACCESS_KEY_ID", "id", 1);
    setenv("AWS_SECRET_ACCESS_KEY", "secret", 1);
  }
  ~S3UriTest() override {
    for (const char* name : {"AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY", "AWS_ENDPOINT_URL",
                             "AWS_REGION", "AWS_SESSION_TOKEN", "PARALLAX_S3_CREDENTIALS"}) {
      unsetenv(name);
    }
  }
};

TEST_F(S3UriTest, BucketPrefixAndSettingsAreRead) {
  const auto aws = ParseS3Uri("s3://data/a/b/?region=eu-west-1");
  ASSERT_TRUE(aws.ok()) << aws.status();
  EXPECT_EQ(aws->bucket, "data");
  EXPECT_EQ(aws->prefix, "a/b");
  EXPECT_EQ(aws->endpoint, "https://s3.eu-west-1.amazonaws.com");
  EXPECT_FALSE(aws->path_style);
  const auto own = ParseS3Uri("s3://data?endpoint=http%3A//minio:9000/");
  EXPECT_EQ(own->endpoint, "http://minio:9000");
  EXPECT_TRUE(own->path_style);
  setenv("AWS_ENDPOINT_URL", "https://ceph", 1);
  setenv("AWS_REGION", "here", 1);
  EXPECT_EQ(ParseS3Uri("s3://data")->endpoint, "https://ceph");
  EXPECT_EQ(ParseS3Uri("s3://data")->region, "here");
}

TEST_F(S3UriTest, ABucketWithADotIsInThePathAndChinaHasAnEndOfItsOwn) {
  EXPECT_TRUE(ParseS3Uri("s3://my.data")->path_style);
  EXPECT_FALSE(ParseS3Uri("s3://my.data?path_style=0")->path_style);
  EXPECT_EQ(ParseS3Uri("s3://data?region=cn-north-1")->endpoint,
            "https://s3.cn-north-1.amazonaws.com.cn");
}

TEST_F(S3UriTest, APercentSignThatBeginsNoCodeStays) {
  EXPECT_EQ(ParseS3Uri("s3://data?endpoint=http://minio%3A9000/%1g%-1%")->endpoint,
            "http://minio:9000/%1g%-1%");
}

TEST_F(S3UriTest, MistakesAreNamed) {
  for (const char* uri :
       {"s3://", "s3:///a", "s3://b/../c", "s3://b?colour=red", "s3://b?endpoint=ftp://x",
        "s3://b?endpoint=/", "s3://b?path_style=yes"}) {
    EXPECT_EQ(ParseS3Uri(uri).status().code(), absl::StatusCode::kInvalidArgument) << uri;
  }
  unsetenv("AWS_SECRET_ACCESS_KEY");
  EXPECT_THAT(std::string(ParseS3Uri("s3://b").status().message()),
              HasSubstr("AWS_SECRET_ACCESS_KEY"));
  setenv("PARALLAX_S3_CREDENTIALS", "true", 1);
  EXPECT_FALSE(ParseS3Uri("s3://b").ok()) << "half of the keys is a mistake";
  unsetenv("AWS_ACCESS_KEY_ID");
  EXPECT_EQ(ParseS3Uri("s3://b")->credentials_command, "true");
}

TEST_F(S3UriTest, AStoresUriFindsItAgainAndHoldsNoSecret) {
  const S3Options options = Options();
  const auto store = *OpenS3Store(options);
  EXPECT_EQ(store->Uri().find(options.secret_key), std::string::npos);
  setenv("AWS_ACCESS_KEY_ID", options.access_key.c_str(), 1);
  setenv("AWS_SECRET_ACCESS_KEY", options.secret_key.c_str(), 1);
  ASSERT_TRUE(store->Put("a/b", "x").ok());
  const auto again = OpenStore(store->Uri());
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(*(*again)->Get("a/b"), "x");
}

}  // namespace
}  // namespace parallax
