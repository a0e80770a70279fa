// SQLite's C interface with owners. Private to the store.
#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "common/base/result.h"

namespace lodestream::store {

class Database;

// A prepared statement; parameters are bound in their order.
class Statement {
  public:
    Statement& bind(std::string_view text);
    Statement& bind(std::int64_t number);
    // True: a row is there; false: done. Errors: conflict (a constraint), unavailable (busy), io.
    Result<bool> step();
    Status run();  // steps to the end

    std::string text(int column) const;
    std::int64_t number(int column) const;

  private:
    friend class Database;
    struct Finalize {
        void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
    };
    Statement(sqlite3* database, sqlite3_stmt* statement) : database_(database), statement_(statement) {}

    sqlite3* database_;
    std::unique_ptr<sqlite3_stmt, Finalize> statement_;
    int next_parameter_ = 1;
};

class Database {
  public:
    static Result<Database> open(const std::filesystem::path& file);

    Result<Statement> prepare(const char* sql) const;
    Status execute(const char* sql) const;
    Result<std::int64_t> query_number(const char* sql) const;

  private:
    struct Close {
        void operator()(sqlite3* database) const { sqlite3_close(database); }
    };
    explicit Database(sqlite3* database) : database_(database) {}

    std::unique_ptr<sqlite3, Close> database_;
};

// A write transaction: takes the write lock at once, rolls back unless committed.
class Transaction {
  public:
    static Result<Transaction> begin(const Database& database);
    Transaction(Transaction&& other) noexcept : database_(std::exchange(other.database_, nullptr)) {}
    Transaction& operator=(Transaction&&) = delete;
    ~Transaction();
    Status commit();

  private:
    explicit Transaction(const Database& database) : database_(&database) {}
    const Database* database_;
};

}  // namespace lodestream::store
