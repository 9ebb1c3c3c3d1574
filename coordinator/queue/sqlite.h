// SQLite behind RAII: a connection and statements on it. This folder is SQLite's only home.
//
// Every statement is prepared once a connection and found again by its SQL. A Query borrows one and
// gives it back, reset, at the end of its life; two live Queries of one connection must not have
// the same SQL. A connection is used by one thread at a time. Errors carry SQLite's message and the
// SQL; the code says what to do: kDataLoss (corrupt, not a database), kResourceExhausted (disk
// full), kUnavailable (I/O error), kDeadlineExceeded (interrupted), kFailedPrecondition (constraint
// or trigger: an invariant held), kInternal.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include "common/base/hash.h"
#include "common/base/status.h"

struct sqlite3;
struct sqlite3_stmt;

namespace parallax {

// A string bound as a blob.
struct SqlBlob {
  std::string_view bytes;
};

class SqliteConnection {
 public:
  enum class Mode { kReadWriteCreate, kReadWrite, kReadOnly };
  static absl::StatusOr<std::unique_ptr<SqliteConnection>> Open(const std::string& path, Mode mode,
                                                                const std::string& vfs = "");
  ~SqliteConnection();
  SqliteConnection(const SqliteConnection&) = delete;
  SqliteConnection& operator=(const SqliteConnection&) = delete;

  // Runs statements without parameters (schema, pragmas).
  absl::Status Execute(const std::string& sql);
  // Runs one statement to its end.
  template <typename... Args>
  absl::Status Run(const char* sql, const Args&... args);
  // The first column of the first row, if there is one.
  template <typename... Args>
  absl::StatusOr<std::optional<int64_t>> Integer(const char* sql, const Args&... args);
  absl::StatusOr<std::string> Text(const char* sql);

  int64_t last_insert_id() const;
  int changes() const;           // Rows of the last INSERT, UPDATE or DELETE.
  int64_t rows_written() const;  // Of all of them since the connection was opened.
  bool in_transaction() const;   // False after SQLite rolled back by itself.
  sqlite3* raw() const { return db_; }

  // Called before each step of a statement that writes, and may refuse it: fail points.
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

// One execution of a statement.
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

  int64_t Int(int column) const;
  double Real(int column) const;
  bool IsNull(int column) const;
  std::string_view Text(int column) const;  // Until the next Next().
  std::string_view Blob(int column) const;  // Likewise.
  Sha256Digest Digest(int column) const;    // Of a 32-byte blob; zeros otherwise.

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

}  // namespace parallax
