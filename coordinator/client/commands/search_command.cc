// search: looks for the settings of a generator whose pairs train best.
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/base/names.h"
#include "common/config/config.h"
#include "common/store/store.h"
#include "coordinator/client/command.h"
#include "coordinator/client/content/ship_content.h"
#include "coordinator/client/content/study_options.h"
#include "coordinator/client/interrupt.h"
#include "coordinator/client/runs/follow.h"
#include "coordinator/client/search/best_recipe.h"
#include "coordinator/client/search/search_names.h"
#include "coordinator/client/search/search_picture.h"
#include "coordinator/client/search/search_view.h"
#include "coordinator/view/json_list.h"
#include "coordinator/view/search_json.h"

namespace parallax::client {
namespace {

struct SearchOptions {
  StudyOptions study{.takes_search = true};
  bool watch = false, stop = false, forget = false, yes = false;
  std::string best, picture;
};

absl::StatusOr<v1::SearchStatus> FindSearch(const std::string& name, Connection& connection) {
  ASSIGN_OR_RETURN(const v1::ListSearchesReply reply, connection.ListSearches(name));
  if (reply.searches_size() != 1) return NotFound("no search '{}'", name);
  return reply.searches(0);
}

// Finds a search by its name; begins that of a file or of a built-in study.
absl::StatusOr<v1::SearchStatus> FindOrOpen(const SearchOptions& options, Connection& connection) {
  const std::string& named = options.study.study;
  std::error_code error;
  if (!std::filesystem::is_regular_file(named, error) && IsFolderName(named)) {
    absl::StatusOr<v1::SearchStatus> known = FindSearch(named, connection);
    const std::vector<std::string> built_in = BuiltinStudies();
    const bool is_built_in = std::count(built_in.begin(), built_in.end(), named) > 0;
    if (!absl::IsNotFound(known.status()) || !is_built_in) return known;
  }
  ASSIGN_OR_RETURN(v1::StudySpec study, ResolveStudy(options.study));
  if (!study.has_search()) {
    return InvalidArgument(
        "study '{}' has no `search`, which says what is varied: `parallax submit "
        "{}` makes its pairs",
        study.name(), named);
  }
  if (options.stop || options.forget) return FindSearch(study.name(), connection);
  RETURN_IF_ERROR(HashContent(study, FolderReaders::kOfFarm));
  RETURN_IF_ERROR(ShipContent(study, *connection.RemoteStore()).status());
  return connection.OpenSearch(study);
}

bool IsAtEnd(const v1::SearchStatus& search) {
  return search.state() == "ended" || search.state() == "stopped" || search.state() == "failed";
}

// Shows a search while it goes on: its table, redrawn in place, on a terminal; a line after each
// change elsewhere.
class SearchDisplay {
 public:
  explicit SearchDisplay(Session& session) : session_(session), block_(session.out()) {}

  void Show(const v1::SearchStatus& search) {
    if (session_.options.json) {
      nlohmann::ordered_json json = SearchJson(search);
      if (json.dump() != last_) session_.PrintJson(json, true);
      last_ = json.dump();
      return;
    }
    if (session_.out().interactive) {
      if (search.needs() != needs_ && !search.needs().empty()) block_.Print(search.needs());
      needs_ = search.needs();
      return block_.Update(SearchLines(search, session_.out()));
    }
    std::string line = SearchProgress(search);
    for (const std::string& more : {search.waits_for(), search.needs()}) {
      if (!more.empty()) line += "; " + more;
    }
    if (line != last_) *session_.out().stream << line << "\n" << std::flush;
    last_ = line;
  }
  // Writes a note that stays.
  void Note(const std::string& note) {
    if (session_.out().interactive && !session_.options.json) return block_.Print(note);
    session_.PrintNote(note);
  }
  void Clear() { block_.Clear(); }
  void Keep() { block_.Keep(); }

 private:
  Session& session_;
  LiveBlock block_;
  std::string last_, needs_;
};

// Follows a search until it ends, and sets `search` to how it ended. Returns false if the user has
// ended watching.
absl::StatusOr<bool> WatchSearch(Connection& connection, Session& session,
                                 v1::SearchStatus& search) {
  const Environment& environment = session.environment;
  InterruptScope interrupts;
  SearchDisplay display(session);
  double heard_s = SteadySeconds(*environment.clock);
  bool was_away = false;
  while (true) {
    const absl::StatusOr<v1::SearchStatus> now = FindSearch(search.name(), connection);
    const double now_s = SteadySeconds(*environment.clock);
    const bool is_away = absl::IsUnavailable(now.status());
    if (!now.ok() && (!is_away || now_s - heard_s > kPatience_s)) return now.status();
    if (is_away && !was_away) display.Note(AwayNote(now_s - heard_s));
    was_away = is_away;
    if (now.ok()) {
      heard_s = now_s;
      search = *now;
      if (IsAtEnd(search) && !session.options.json) break;
      display.Show(search);
      if (IsAtEnd(search)) break;
      if (session.OutputIsClosed()) return false;
    }
    if (interrupts.WaitFor(std::chrono::duration<double>(environment.poll_s))) {
      display.Keep();
      session.PrintNote("the search continues; `parallax search " + search.name() +
                        " --watch` follows it again");
      return false;
    }
  }
  display.Clear();
  return true;
}

absl::Status WriteFiles(const SearchOptions& options, const v1::SearchStatus& search,
                        const Session& session) {
  if (!options.picture.empty()) {
    RETURN_IF_ERROR(WriteFileAtomically(options.picture, SearchSvg(search)));
  }
  if (options.best.empty()) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::string recipe, BestRecipe(search));
  RETURN_IF_ERROR(WriteFileAtomically(options.best, recipe));
  session.PrintNote("`parallax run " + options.best + " --out DIR` makes the best recipe's pairs");
  return absl::OkStatus();
}

absl::StatusOr<ExitCode> ListAll(const SearchOptions& options, Connection& connection,
                                 const Session& session) {
  const bool is_one = options.watch || options.stop || options.forget || !options.best.empty() ||
                      !options.picture.empty();
  if (is_one) return InvalidArgument("these options need the search's name or its study");
  ASSIGN_OR_RETURN(const v1::ListSearchesReply reply, connection.ListSearches(""));
  if (!session.options.json) {
    PrintSearches(reply, session.out());
    return kExitOk;
  }
  return session.PrintJson({{"searches", JsonList(reply.searches(), SearchJson)}});
}

absl::StatusOr<ExitCode> Search(const SearchOptions& options, Session& session) {
  const std::string& picture = options.picture;
  if (!picture.empty() && !picture.ends_with(".svg")) {
    return InvalidArgument("--picture: {} was given, a name that ends with .svg is needed",
                           picture);
  }
  ASSIGN_OR_RETURN(const auto connection, session.Connect());
  if (options.study.study.empty()) return ListAll(options, *connection, session);
  ASSIGN_OR_RETURN(v1::SearchStatus search, FindOrOpen(options, *connection));
  if (options.stop || options.forget) {
    if (options.forget) {
      RETURN_IF_ERROR(session.Confirm(
          "the trials of '" + search.name() + "', their pairs and networks are removed",
          options.yes));
    }
    ASSIGN_OR_RETURN(search, connection->StopSearch(search.name(), options.forget));
    session.PrintNote(search.name() + (options.forget ? " is being removed" : " is stopped"));
    return session.options.json ? session.PrintJson(SearchJson(search)) : kExitOk;
  }
  if (options.watch) {
    ASSIGN_OR_RETURN(const bool is_at_end, WatchSearch(*connection, session, search));
    if (!is_at_end) return kExitInterrupted;
  }
  if (!session.options.json) {
    for (const std::string& line : SearchLines(search, session.out())) {
      *session.out().stream << line << "\n";
    }
    if (!search.needs().empty()) session.PrintNote(search.needs());
  } else if (!options.watch) {
    session.PrintJson(SearchJson(search));
  }
  RETURN_IF_ERROR(WriteFiles(options, search, session));
  const bool has_failed =
      search.state() == "failed" || (options.watch && search.state() != "ended");
  return has_failed ? kExitFailed : kExitOk;
}

}  // namespace

void RegisterSearch(Registry& registry) {
  CLI::App* command = registry.AddCommand(
      registry.app, "search", "Look for the settings whose pairs train best",
      "A study with `search:` names the fields that may vary, their values, and the benchmarks\n"
      "whose error it minimises. Trials train on rungs of more and more pairs; significantly\n"
      "worse ones stop. The best is compared with the study's own settings once more, on pairs\n"
      "and benchmarks that the search has not seen. Without STUDY: lists searches.\n"
      "`parallax plan FILE` estimates the cost of a search.\n"
      "\n"
      "Examples:\n"
      "  parallax search camera.yaml --watch\n"
      "  parallax search camera                     its state and trials\n"
      "  parallax search camera --best best.yaml && parallax run best.yaml --out out/best\n"
      "  parallax search camera --picture camera.svg\n");
  auto options = std::make_shared<SearchOptions>();
  command->add_option("STUDY", options->study.study,
                      "A file, a built-in study's name, or the name of a search");
  command->add_flag("--watch", options->watch, "Follow it until it ends; Ctrl-C ends watching");
  AddOption(command, "--best", "FILE", options->best, "Write the best recipe as a study file");
  AddOption(command, "--picture", "FILE", options->picture,
            "Draw errors by trial and by core-hours, and the trials' values (.svg)");
  CLI::Option* stop = command->add_flag("--stop", options->stop,
                                        "Stop the search: cancel its jobs; its file resumes it");
  CLI::Option* forget = command->add_flag(
      "--forget", options->forget, "Stop the search and remove its trials, pairs and networks");
  command->add_flag("-y,--yes", options->yes, "With --forget: without asking");
  for (CLI::Option* end : {stop, forget}) {
    for (const char* other : {"--watch", "--best", "--picture"}) {
      end->excludes(command->get_option(other));
    }
  }
  command->group(kCoordinatorCommands);
  registry.AddConnectionOptions(command);
  registry.SetAction(command, [options](Session& session) { return Search(*options, session); });
}

}  // namespace parallax::client
