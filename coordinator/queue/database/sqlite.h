// RAII classes for SQLite: a connection and queries on it. Only this folder uses SQLite.
//
// A connection prepares every statement once and finds it again by its SQL. A SqliteQuery borrows
// the statement and resets it when destroyed, so two live queries of a connection must not have the
// same SQL. Only one thread at a time may use a connection.
//
// Errors have SQLite's message and the SQL. Codes: kDataLoss (corrupt, or not a database),
// kResourceExhausted (disk full), kUnavailable (I/O error), kDeadlineExceeded (interrupted),
// kFailedPrecondition (a constraint or trigger refused the change), else kInternal.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "common/base/hash.h"
#include "common/base/status.h"

struct sqlite3;
struct sqlite3_stmt;

namespace parallax {

// Marks a string that is bound as a blob.
struct SqlBlob {
  std::string_view bytes;
};

// Returns what is bound for an id: NULL for 0.
inline std::optional<int64_t> NullIfZero(int64_t id) {
  return id == 0 ? std::nullopt : std::optional<int64_t>(id);
}

class SqliteConnection {
 public:
  enum class Mode { kReadWriteCreate, kReadWrite, kReadOnly };
  // Opens a database. `vfs` names a registered SQLite VFS; empty: the system's.
  static absl::StatusOr<std::unique_ptr<SqliteConnection>> Open(const std::string& path, Mode mode,
                                                                const std::string& vfs = "");
  ~SqliteConnection();
  SqliteConnection(const SqliteConnection&) = delete;
  SqliteConnection& operator=(const SqliteConnection&) = delete;

  // Runs one or more statements without parameters (schema, pragmas).
  absl::Status Execute(const std::string& sql);
  // Runs one statement to its end.
  template <typename... Args>
  absl::Status Run(const char* sql, const Args&... args);
  // Runs a query and returns the first column of the first row, if there is one and it is not NULL.
  template <typename... Args>
  absl::StatusOr<std::optional<int64_t>> Integer(const char* sql, const Args&... args);
  // Runs a query and returns whether it has a row.
  template <typename... Args>
  absl::StatusOr<bool> Has(const char* sql, const Args&... args);
  // Runs a query and returns the first column of all rows.
  template <typename... Args>
  absl::StatusOr<std::vector<int64_t>> Integers(const char* sql, const Args&... args);
  // As Integer, for text without arguments; "" if there is no row.
  absl::StatusOr<std::string> Text(const char* sql);

  int64_t last_insert_id() const;
  int changes() const;           // Rows of the last INSERT, UPDATE or DELETE.
  int64_t rows_written() const;  // Rows of all such statements since the connection was opened.
  bool in_transaction() const;   // False after SQLite rolled back by itself.
  sqlite3* raw() const { return db_; }

  // Called before each step of a statement that writes. An error refuses the step (fail points).
  std::function<absl::Status()> before_write;

 private:
  friend class SqliteQuery;
  explicit SqliteConnection(sqlite3* db) : db_(db) {}
  sqlite3_stmt* Prepare(const char* sql, absl::Status& status);
  absl::Status ErrorOf(int code, const char* sql) const;

  sqlite3* db_;
  std::map<std::string, sqlite3_stmt*, std::less<>> statements_;
  std::map<const void*, sqlite3_stmt*> by_literal_;
};

// One execution of a statement. Check status() after the last Next():
//   SqliteQuery query(db, "SELECT id, name FROM studies WHERE id > ?1", 7);
//   while (query.Next()) { ... query.Int(0) ... query.Text(1) ... }
//   RETURN_IF_ERROR(query.status());
class SqliteQuery {
 public:
  template <typename... Args>
  SqliteQuery(SqliteConnection& db, const char* sql, const Args&... args) : db_(db), sql_(sql) {
    statement_ = db.Prepare(sql, status_);
    if (statement_ == nullptr) return;
    int index = 0;
    (Bind(++index, args), ...);
  }
  ~SqliteQuery();
  SqliteQuery(const SqliteQuery&) = delete;
  SqliteQuery& operator=(const SqliteQuery&) = delete;

  bool Next();  // False at the end and after an error.
  const absl::Status& status() const { return status_; }
  // Returns `row_of()` of each row that is left.
  template <typename RowOf>
  auto Rows(const RowOf& row_of) -> absl::StatusOr<std::vector<decltype(row_of())>> {
    std::vector<decltype(row_of())> rows;
    while (Next()) rows.push_back(row_of());
    RETURN_IF_ERROR(status_);
    return rows;
  }

  // Columns of the current row, from 0. Require that the last Next() returned true.
  int64_t Int(int column) const;
  double Real(int column) const;
  bool IsNull(int column) const;
  std::string_view Text(int column) const;  // Valid until the next Next().
  std::string_view Blob(int column) const;  // Valid until the next Next().
  Sha256Digest Digest(int column) const;    // A blob of 32 bytes; zeros for anything else.

 private:
  template <typename T>
  void Bind(int index, const T& value) {
    if constexpr (std::is_same_v<T, std::nullptr_t>) {
      BindNull(index);
    } else if constexpr (std::is_same_v<T, SqlBlob>) {
      BindBlob(index, value.bytes);
    } else if constexpr (std::is_same_v<T, Sha256Digest>) {
      BindBlob(index, {reinterpret_cast<const char*>(value.data()), value.size()});
    } else if constexpr (std::is_floating_point_v<T>) {
      BindReal(index, value);
    } else if constexpr (std::is_integral_v<T>) {
      BindInt(index, static_cast<int64_t>(value));
    } else {
      BindText(index, std::string_view(value));
    }
  }
  // Not inlined: GCC 12 then takes the value of an empty one for read (-Wmaybe-uninitialized).
  template <typename T>
  [[gnu::noinline]] void Bind(int index, const std::optional<T>& value) {
    if (value) {
      Bind(index, *value);
    } else {
      BindNull(index);
    }
  }
  void BindNull(int index);
  void BindInt(int index, int64_t value);
  void BindReal(int index, double value);
  void BindText(int index, std::string_view text);
  void BindBlob(int index, std::string_view bytes);

  SqliteConnection& db_;
  const char* sql_;
  sqlite3_stmt* statement_ = nullptr;
  absl::Status status_;
};

template <typename... Args>
absl::Status SqliteConnection::Run(const char* sql, const Args&... args) {
  SqliteQuery query(*this, sql, args...);
  while (query.Next()) {
  }
  return query.status();
}

template <typename... Args>
absl::StatusOr<std::optional<int64_t>> SqliteConnection::Integer(const char* sql,
                                                                 const Args&... args) {
  SqliteQuery query(*this, sql, args...);
  std::optional<int64_t> value;
  if (query.Next() && !query.IsNull(0)) value = query.Int(0);
  RETURN_IF_ERROR(query.status());
  return value;
}

template <typename... Args>
absl::StatusOr<bool> SqliteConnection::Has(const char* sql, const Args&... args) {
  SqliteQuery query(*this, sql, args...);
  const bool has = query.Next();
  RETURN_IF_ERROR(query.status());
  return has;
}

template <typename... Args>
absl::StatusOr<std::vector<int64_t>> SqliteConnection::Integers(const char* sql,
                                                                const Args&... args) {
  SqliteQuery query(*this, sql, args...);
  return query.Rows([&] { return query.Int(0); });
}

}  // namespace parallax
