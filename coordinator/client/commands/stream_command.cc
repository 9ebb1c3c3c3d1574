// stream: pairs of an endless study, for trainings that take them as they are made.
#include <fmt/core.h>
#include <poll.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <filesystem>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/base/names.h"
#include "common/config/config.h"
#include "common/store/store.h"
#include "coordinator/client/command.h"
#include "coordinator/client/content/own_folders.h"
#include "coordinator/client/content/ship_content.h"
#include "coordinator/client/content/study_options.h"
#include "coordinator/client/interrupt.h"
#include "coordinator/client/runs/follow.h"
#include "coordinator/client/runs/local_farm.h"
#include "coordinator/client/runs/store_reader.h"
#include "coordinator/client/views/text.h"
#include "coordinator/client/views/text_table.h"
#include "coordinator/view/json_list.h"
#include "coordinator/view/status_view.h"
#include "worker/dataset/export/stream_sample.h"

namespace parallax::client {
namespace {

constexpr double kWait_s = 10;
constexpr int kPairsAtOnce = 16;
constexpr std::chrono::milliseconds kEndEvery{500};  // Time between looks for the end of a farm.

struct StreamOptions {
  StudyOptions study{.takes_endless = true};
  bool close = false, tar = false;
  std::string consumer = "tar";
  int rank = 0, ranks = 1;
  int64_t most = 0;
  int workers = 0;  // 0: of the coordinator's farm.
  std::string out;
  int pid = 0;  // 0: none.
};

nlohmann::ordered_json StreamsJson(const v1::ListStreamsReply& reply) {
  return {{"streams", JsonList(reply.streams(), StreamJson)}};
}

ExitCode PrintStreams(const v1::ListStreamsReply& reply, const Session& session) {
  if (session.options.json) return session.PrintJson(StreamsJson(reply));
  if (reply.streams().empty()) {
    *session.out().stream << "no stream is open; `parallax stream FILE` begins one\n";
    return kExitOk;
  }
  Table table({"STREAM", Right("CHUNKS MADE"), Right("BEGUN"), Right("PAIRS KEPT"), "CONSUMERS"});
  for (const v1::StreamStatus& stream : reply.streams()) {
    std::string consumers;
    for (const v1::StreamConsumer& consumer : stream.consumers()) {
      consumers += consumers.empty() ? "" : ", ";
      consumers += consumer.name();
      if (consumer.ranks() > 1)
        consumers += fmt::format(" {}/{}", consumer.rank(), consumer.ranks());
      consumers += fmt::format(" in round {}", consumer.acknowledged() >> 32);
    }
    table.AddRow({stream.name() + (stream.closed() ? " (closing)" : ""),
                  FormatCount(stream.chunks_made()), FormatCount(stream.chunks_begun()),
                  FormatCount(stream.pairs_kept()), consumers.empty() ? "none" : consumers});
  }
  table.Print(session.out());
  for (const v1::StreamStatus& stream : reply.streams()) {
    if (!stream.needs().empty()) session.PrintNote(stream.name() + ": " + stream.needs());
  }
  return kExitOk;
}

// Writes all bytes to standard output. Returns false when its reader is gone.
absl::StatusOr<bool> WriteOut(const std::string& bytes) {
  size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t written = ::write(STDOUT_FILENO, bytes.data() + done, bytes.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0 && errno == EPIPE) return false;
    if (written < 0) return ErrnoError(errno, "write standard output");
    done += static_cast<size_t>(written);
  }
  return true;
}

// Returns whether nobody reads standard output, a pipe, any more.
bool ReaderIsGone() {
  pollfd out{STDOUT_FILENO, 0, 0};
  return ::poll(&out, 1, 0) > 0 && (out.revents & POLLERR) != 0;
}

// A coordinator that stops cancels the calls that wait in it.
bool IsAway(const absl::Status& status) {
  return absl::IsUnavailable(status) || absl::IsCancelled(status);
}

// Repeats `call` while the coordinator is away: one that restarts is back soon. `farm` may be null.
// Errors: the farm's; those of `call`, such as kUnavailable after kPatience_s or an interrupt.
absl::Status WithPatience(const std::function<absl::Status()>& call, InterruptScope& interrupt,
                          const LocalFarm* farm, const Session& session) {
  std::optional<double> since_s;
  while (true) {
    if (farm != nullptr) RETURN_IF_ERROR(farm->status());
    const absl::Status status = call();
    if (!IsAway(status) || interrupt.count() > 0) return status;
    const double now_s = SteadySeconds(*session.environment.clock);
    if (!since_s) session.PrintNote(AwayNote(0));
    since_s = since_s.value_or(now_s);
    if (now_s - *since_s > kPatience_s) return status;
    if (interrupt.WaitFor(std::chrono::duration<double>(session.environment.poll_s))) return status;
  }
}

// Writes pairs as members of one tar file until somebody ends it. A pair is acknowledged when its
// bytes are written. `farm` makes the pairs, unless it is null.
absl::StatusOr<ExitCode> WriteTar(const std::string& name, const StreamOptions& options,
                                  Connection& connection, InterruptScope& interrupt,
                                  const LocalFarm* farm, const Session& session) {
  ASSIGN_OR_RETURN(
      const auto reader,
      StoreReader::Open(connection,
                        fmt::format("{}/parallax-stream-{}",
                                    std::filesystem::temp_directory_path().string(), ::getpid())));
  v1::NextPairsRequest request;
  request.set_stream(name);
  request.set_consumer(options.consumer);
  request.set_rank(options.rank);
  request.set_ranks(options.ranks);
  request.set_wait_s(kWait_s);
  request.set_limit(kPairsAtOnce);
  request.set_resume(true);
  int64_t written = 0;
  std::string waits_for;
  v1::NextPairsReply reply;
  const auto next = [&]() -> absl::Status {
    ASSIGN_OR_RETURN(reply, connection.NextPairs(request));
    return absl::OkStatus();
  };
  while (interrupt.count() == 0 && (options.most == 0 || written < options.most)) {
    const absl::Status answered = WithPatience(next, interrupt, farm, session);
    if (interrupt.count() > 0) break;
    RETURN_IF_ERROR(answered);
    request.set_resume(false);
    if (reply.pairs().empty() && ReaderIsGone()) return kExitOk;
    if (reply.pairs().empty() && reply.waits_for() != waits_for) {
      session.PrintNote("waits: " + reply.waits_for());
      waits_for = reply.waits_for();
    }
    uint64_t after = reply.position();
    for (const v1::StreamedPair& pair : reply.pairs()) {
      if (interrupt.count() > 0 || (options.most > 0 && written == options.most)) {
        after = pair.position();
        break;
      }
      if (!reader->is_local()) {
        const absl::Status brought =
            WithPatience([&] { return reader->Bring(pair.frame()); }, interrupt, farm, session);
        if (IsAway(brought) && interrupt.count() > 0) {
          after = pair.position();
          break;
        }
        RETURN_IF_ERROR(brought);
      }
      ASSIGN_OR_RETURN(const std::string members,
                       StreamSample(pair, reader->folder() + "/" + pair.frame().path()));
      reader->Drop(pair.frame());
      ASSIGN_OR_RETURN(const bool is_read, WriteOut(members));
      if (!is_read) return kExitOk;  // What it took last is not acknowledged: it comes again.
      ++written;
    }
    request.set_position(after);
    request.set_acknowledged(after);
  }
  request.set_wait_s(0);
  request.set_limit(1);
  const absl::Status acknowledged = WithPatience(next, interrupt, farm, session);  // The last ones.
  RETURN_IF_ERROR(WriteOut(StreamEnd()).status());
  RETURN_IF_ERROR(acknowledged);
  return kExitOk;
}

// Waits until the user, or the process that the farm is for, ends. Errors: the farm's.
absl::Status WaitForTheEnd(const LocalFarm& farm, int pid, InterruptScope& interrupt) {
  const int process = pid == 0 ? -1 : static_cast<int>(::syscall(SYS_pidfd_open, pid, 0));
  if (pid != 0 && process < 0) {
    return errno == ESRCH ? absl::OkStatus() : ErrnoError(errno, fmt::format("--pid {}", pid));
  }
  pollfd watched{process, POLLIN, 0};
  absl::Status status;
  while (status.ok() && !interrupt.WaitFor(kEndEvery) && ::poll(&watched, 1, 0) <= 0) {
    status = farm.status();
  }
  if (process >= 0) ::close(process);
  return status;
}

// Makes the stream's pairs on this machine, until its consumer or the user ends it.
absl::StatusOr<ExitCode> StreamHere(const StreamOptions& options, Session& session) {
  ASSIGN_OR_RETURN(v1::StudySpec study, ResolveStudy(options.study));
  if (!study.has_stream()) {
    return InvalidArgument("{}: pairs: {}, allowed in a stream is `pairs: endless`",
                           options.study.study, study.pairs());
  }
  RETURN_IF_ERROR(HashContent(study, FolderReaders::kOfRun));
  NameOwnCopies(study);
  InterruptScope interrupt;
  ASSIGN_OR_RETURN(const auto farm,
                   LocalFarm::Start(options.out.empty() ? study.name() + "-stream" : options.out,
                                    options.workers, session.environment.clock));
  ASSIGN_OR_RETURN(const auto connection, Connection::Open(farm->address()));
  ASSIGN_OR_RETURN(v1::ListStreamsReply reply, connection->ListStreams(""));
  const bool is_other = !reply.streams().empty() && reply.streams(0).name() != study.name();
  absl::StatusOr<v1::StreamStatus> opened = AlreadyExists("another");
  if (!is_other) opened = connection->OpenStream(study);
  if (absl::IsAlreadyExists(opened.status())) {
    return AlreadyExists(
        "{} has a stream of another study or of other settings: remove it to begin anew, or choose "
        "another --out",
        farm->dir());
  }
  RETURN_IF_ERROR(opened.status());
  reply.clear_streams();
  *reply.add_streams() = *std::move(opened);
  if (options.tar)
    return WriteTar(study.name(), options, *connection, interrupt, farm.get(), session);
  if (session.options.json) {
    nlohmann::ordered_json json = StreamsJson(reply);
    json["address"] = farm->address();
    json["out"] = farm->dir();
    session.PrintJson(json, /*one_line=*/true);
  } else {
    PrintStreams(reply, session);
    *session.err().stream << "pairs are made while this runs, until Ctrl-C; in Python: stream(\""
                          << study.name() << "\", \"" << farm->address() << "\")\n"
                          << std::flush;
  }
  RETURN_IF_ERROR(WaitForTheEnd(*farm, options.pid, interrupt));
  return kExitOk;
}

absl::StatusOr<ExitCode> StreamOfCoordinator(StreamOptions& options, Session& session) {
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  if (options.study.study.empty()) {
    if (options.close || options.tar) {
      return InvalidArgument("{} needs the stream's name or its study",
                             options.close ? "--close" : "--tar");
    }
    ASSIGN_OR_RETURN(const v1::ListStreamsReply reply, connection->ListStreams(""));
    return PrintStreams(reply, session);
  }
  std::string name = options.study.study;
  v1::ListStreamsReply reply;
  std::error_code error;
  bool is_study = std::filesystem::is_regular_file(name, error) || !IsFolderName(name);
  if (!is_study) {  // A stream that is open, or a built-in study.
    absl::StatusOr<v1::ListStreamsReply> open = connection->ListStreams(name);
    const std::vector<std::string> built_in = BuiltinStudies();
    is_study =
        absl::IsNotFound(open.status()) && std::count(built_in.begin(), built_in.end(), name) > 0;
    if (!is_study) {
      RETURN_IF_ERROR(open.status());
      reply = *std::move(open);
    }
  }
  if (is_study) {
    ASSIGN_OR_RETURN(v1::StudySpec study, ResolveStudy(options.study));
    name = study.name();
    if (!options.close) {
      RETURN_IF_ERROR(HashContent(study, FolderReaders::kOfFarm));
      RETURN_IF_ERROR(ShipContent(study, *connection->RemoteStore()).status());
      ASSIGN_OR_RETURN(*reply.add_streams(), connection->OpenStream(study));
    }
  }
  if (options.close) {
    reply.clear_streams();
    ASSIGN_OR_RETURN(*reply.add_streams(), connection->CloseStream(name, ""));
  }
  if (options.tar) {
    InterruptScope interrupt;
    return WriteTar(name, options, *connection, interrupt, nullptr, session);
  }
  return PrintStreams(reply, session);
}

absl::StatusOr<ExitCode> Stream(StreamOptions& options, Session& session) {
  if (options.workers > 0) return StreamHere(options, session);
  const absl::StatusOr<ExitCode> done = StreamOfCoordinator(options, session);
  if (!absl::IsUnavailable(done.status()) || options.study.study.empty() || options.close) {
    return done;
  }
  return Unavailable("{}, or let this machine be the farm: --workers 2",
                     ToStd(done.status().message()));
}

}  // namespace

void RegisterStream(Registry& registry) {
  CLI::App* command = registry.AddCommand(
      registry.app, "stream",
      "Pairs of an endless study, for trainings that take them as they are made",
      "A study with `pairs: endless` begins when a stream is opened. Pairs are made ahead of its\n"
      "consumers and forgotten when they are used up. In Python:\n"
      "parallax_data.stream(NAME). Without STUDY: lists the streams. With --workers this machine "
      "is\n"
      "the farm, for as long as the command runs; the same command again goes on.\n"
      "\n"
      "Examples:\n"
      "  parallax stream endless.yaml\n"
      "  parallax stream endless.yaml --workers 2 --tar | python train.py\n"
      "  parallax stream endless --tar | python train.py\n"
      "  parallax stream endless --close\n");
  auto options = std::make_shared<StreamOptions>();
  CLI::Option* study = command->add_option(
      "STUDY", options->study.study, "A file, a built-in study's name, or the name of a stream");
  command->add_flag("--tar", options->tar,
                    "Write pairs to standard output as one endless tar file (WebDataset)");
  AddOption(command, "--consumer", "NAME", options->consumer,
            "With --tar: name of the reader; a reader of this name resumes at its position")
      ->capture_default_str();
  command->add_option("--rank", options->rank, "With --tar: this reader's part, from 0")
      ->check(CLI::Range(0, 65535));
  command->add_option("--ranks", options->ranks, "With --tar: readers that split the stream")
      ->check(CLI::Range(1, 65536));
  command->add_option("--most", options->most, "With --tar: end after N pairs (0: never)")
      ->check(CLI::Range(int64_t{0}, int64_t{1'000'000'000'000}));
  CLI::Option* close = command->add_flag("--close", options->close,
                                         "Close the stream: cancel its jobs and remove its pairs");
  close->excludes(command->get_option("--tar"));
  CLI::Option* workers =
      command
          ->add_option("--workers", options->workers,
                       "Needs no coordinator: N workers on this machine make the pairs until "
                       "Ctrl-C, or until the reader of --tar ends")
          ->check(CLI::Range(1, 256));
  workers->needs(study)->excludes(close);
  AddOption(command, "-o,--out", "DIR", options->out,
            "With --workers: folder of database and pairs, to go on from (default: the "
            "study's name and -stream, in this folder)")
      ->needs(workers);
  command->add_option("--pid", options->pid, "With --workers: end when this process ends, too")
      ->check(CLI::Range(1, std::numeric_limits<int>::max()))
      ->needs(workers);
  AddFollowLinksOption(*command);
  command->group(kCoordinatorCommands);
  registry.AddConnectionOptions(command);
  registry.SetAction(command, [options](Session& session) { return Stream(*options, session); });
}

}  // namespace parallax::client
