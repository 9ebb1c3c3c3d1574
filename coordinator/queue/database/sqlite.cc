#include "coordinator/queue/database/sqlite.h"

#include <fmt/core.h>
#include <sqlite3.h>

#include <algorithm>

#include "common/base/system/memory_end.h"
#include "coordinator/queue/database/page_checksum.h"

namespace parallax {
namespace {

absl::StatusCode CodeOf(int sqlite_code) {
  if (sqlite_code == SQLITE_IOERR_DATA) return absl::StatusCode::kDataLoss;
  switch (sqlite_code & 0xff) {
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
    case SQLITE_FORMAT:
      return absl::StatusCode::kDataLoss;
    case SQLITE_NOMEM:
      EndIfMemoryIsNeeded();
      [[fallthrough]];
    case SQLITE_FULL:
    case SQLITE_TOOBIG:
      return absl::StatusCode::kResourceExhausted;
    case SQLITE_IOERR:
    case SQLITE_PROTOCOL:
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return absl::StatusCode::kUnavailable;
    case SQLITE_INTERRUPT:
      return absl::StatusCode::kDeadlineExceeded;
    case SQLITE_CONSTRAINT:
      return absl::StatusCode::kFailedPrecondition;
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_AUTH:
    case SQLITE_CANTOPEN:
      return absl::StatusCode::kPermissionDenied;
    default:
      return absl::StatusCode::kInternal;
  }
}

}  // namespace

absl::StatusOr<std::unique_ptr<SqliteConnection>> SqliteConnection::Open(const std::string& path,
                                                                         Mode mode,
                                                                         const std::string& vfs) {
  // SQLite's memory statistics cost a lock for each allocation and are not used.
  [[maybe_unused]] static const int once = sqlite3_config(SQLITE_CONFIG_MEMSTATUS, 0);
  int flags = SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE;
  switch (mode) {
    case Mode::kReadWriteCreate:
      flags |= SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
      break;
    case Mode::kReadWrite:
      flags |= SQLITE_OPEN_READWRITE;
      break;
    case Mode::kReadOnly:
      flags |= SQLITE_OPEN_READONLY;
      break;
  }
  sqlite3* db = nullptr;
  const int code = sqlite3_open_v2(path.c_str(), &db, flags, ChecksumVfs(vfs).c_str());
  std::unique_ptr<SqliteConnection> connection(new SqliteConnection(db));
  if (code != SQLITE_OK) {
    return MakeError(CodeOf(code), fmt::format("open database {}: {}", path,
                                               db ? sqlite3_errmsg(db) : sqlite3_errstr(code)));
  }
  return connection;
}

SqliteConnection::~SqliteConnection() {
  for (const auto& [sql, statement] : statements_) sqlite3_finalize(statement);
  sqlite3_close_v2(db_);
}

absl::Status SqliteConnection::ErrorOf(int code, const char* sql) const {
  std::string where(sql);
  std::replace(where.begin(), where.end(), '\n', ' ');
  if (where.size() > 120) where = where.substr(0, 117) + "...";
  const char* what = code == SQLITE_IOERR_DATA ? kWrongPage : sqlite3_errmsg(db_);
  return MakeError(CodeOf(code), fmt::format("database: {} (in: {})", what, where));
}

sqlite3_stmt* SqliteConnection::Prepare(const char* sql, absl::Status& status) {
  // Most SQL is a literal of this program, whose address finds its statement at once.
  if (const auto known = by_literal_.find(sql); known != by_literal_.end()) {
    if (std::string_view(sqlite3_sql(known->second)) == sql) return known->second;
    by_literal_.erase(known);
  }
  auto found = statements_.find(std::string_view(sql));
  if (found == statements_.end()) {
    sqlite3_stmt* statement = nullptr;
    const int code =
        sqlite3_prepare_v3(db_, sql, -1, SQLITE_PREPARE_PERSISTENT, &statement, nullptr);
    if (code != SQLITE_OK) {
      status = ErrorOf(code, sql);
      return nullptr;
    }
    found = statements_.emplace(sql, statement).first;
  }
  by_literal_[sql] = found->second;
  return found->second;
}

absl::Status SqliteConnection::Execute(const std::string& sql) {
  const int code = sqlite3_exec(db_, sql.c_str(), nullptr, nullptr, nullptr);
  return code == SQLITE_OK ? absl::OkStatus() : ErrorOf(code, sql.c_str());
}

absl::StatusOr<std::string> SqliteConnection::Text(const char* sql) {
  SqliteQuery query(*this, sql);
  std::string text;
  if (query.Next()) text = query.Text(0);
  RETURN_IF_ERROR(query.status());
  return text;
}

int64_t SqliteConnection::last_insert_id() const { return sqlite3_last_insert_rowid(db_); }
int SqliteConnection::changes() const { return sqlite3_changes(db_); }
int64_t SqliteConnection::rows_written() const { return sqlite3_total_changes(db_); }
bool SqliteConnection::in_transaction() const { return sqlite3_get_autocommit(db_) == 0; }

SqliteQuery::~SqliteQuery() {
  if (statement_ == nullptr) return;
  sqlite3_reset(statement_);
  sqlite3_clear_bindings(statement_);
}

bool SqliteQuery::Next() {
  if (!status_.ok()) return false;
  if (db_.before_write && sqlite3_stmt_readonly(statement_) == 0) {
    status_ = db_.before_write();
    if (!status_.ok()) return false;
  }
  const int code = sqlite3_step(statement_);
  if (code == SQLITE_ROW) return true;
  if (code != SQLITE_DONE) status_ = db_.ErrorOf(code, sql_);
  return false;
}

int64_t SqliteQuery::Int(int column) const { return sqlite3_column_int64(statement_, column); }
double SqliteQuery::Real(int column) const { return sqlite3_column_double(statement_, column); }
bool SqliteQuery::IsNull(int column) const {
  return sqlite3_column_type(statement_, column) == SQLITE_NULL;
}
std::string_view SqliteQuery::Text(int column) const { return Blob(column); }
std::string_view SqliteQuery::Blob(int column) const {
  const void* data = sqlite3_column_blob(statement_, column);
  return {static_cast<const char*>(data),
          data ? static_cast<size_t>(sqlite3_column_bytes(statement_, column)) : 0};
}
Sha256Digest SqliteQuery::Digest(int column) const {
  Sha256Digest digest{};
  const std::string_view bytes = Blob(column);
  if (bytes.size() == digest.size()) std::copy(bytes.begin(), bytes.end(), digest.begin());
  return digest;
}

// Bound values outlive the Query: its arguments live as long as the full expression or longer,
// except temporaries bound in a declaration; hence SQLITE_TRANSIENT for text and blobs.
void SqliteQuery::BindNull(int index) { sqlite3_bind_null(statement_, index); }
void SqliteQuery::BindInt(int index, int64_t value) {
  sqlite3_bind_int64(statement_, index, value);
}
void SqliteQuery::BindReal(int index, double value) {
  sqlite3_bind_double(statement_, index, value);
}
void SqliteQuery::BindText(int index, std::string_view text) {
  sqlite3_bind_text64(statement_, index, text.data() ? text.data() : "", text.size(),
                      SQLITE_TRANSIENT, SQLITE_UTF8);
}
void SqliteQuery::BindBlob(int index, std::string_view bytes) {
  sqlite3_bind_blob64(statement_, index, bytes.data() ? bytes.data() : "", bytes.size(),
                      SQLITE_TRANSIENT);
}

}  // namespace parallax
