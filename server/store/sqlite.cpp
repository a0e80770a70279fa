#include "server/store/sqlite.h"

namespace lodestream::store {

namespace {

constexpr int busy_timeout_ms = 20'000;  // another process may hold the write lock while it flushes its files

Error error_of(sqlite3* database, int code) {
    const std::string message =
        std::string("catalogue: ") + (database ? sqlite3_errmsg(database) : sqlite3_errstr(code));
    switch (code & 0xff) {
        case SQLITE_CONSTRAINT:
            return fail(ErrorCode::conflict, message);
        case SQLITE_BUSY:
            return fail(ErrorCode::unavailable, message);
        default:
            return fail(ErrorCode::io, message);
    }
}

}  // namespace

Statement& Statement::bind(std::string_view text) {
    sqlite3_bind_text64(statement_.get(), next_parameter_++, text.data() ? text.data() : "", text.size(),
                        SQLITE_TRANSIENT, SQLITE_UTF8);
    return *this;
}

Statement& Statement::bind(std::int64_t number) {
    sqlite3_bind_int64(statement_.get(), next_parameter_++, number);
    return *this;
}

Result<bool> Statement::step() {
    const int code = sqlite3_step(statement_.get());
    if (code == SQLITE_ROW) return true;
    if (code == SQLITE_DONE) return false;
    return error_of(database_, code);
}

Status Statement::run() {
    for (;;) {
        const auto row = step();
        if (!row) return row.error();
        if (!*row) return Nothing{};
    }
}

std::string Statement::text(int column) const {
    const unsigned char* data = sqlite3_column_text(statement_.get(), column);
    if (!data) return {};
    return {reinterpret_cast<const char*>(data),
            static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column))};
}

std::int64_t Statement::number(int column) const {
    return sqlite3_column_int64(statement_.get(), column);
}

Result<Database> Database::open(const std::filesystem::path& file) {
    sqlite3* raw = nullptr;
    const int code =
        sqlite3_open_v2(file.c_str(), &raw, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX, nullptr);
    Database database(raw);
    if (code != SQLITE_OK) return fail(ErrorCode::io, file.string() + ": " + error_of(raw, code).message);
    sqlite3_busy_timeout(raw, busy_timeout_ms);
    sqlite3_extended_result_codes(raw, 1);
    if (auto status = database.execute("PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; PRAGMA foreign_keys=ON;");
        !status)
        return fail(status.error().code, file.string() + ": " + status.error().message);
    return database;
}

Result<Statement> Database::prepare(const char* sql) const {
    sqlite3_stmt* statement = nullptr;
    const int code = sqlite3_prepare_v2(database_.get(), sql, -1, &statement, nullptr);
    if (code != SQLITE_OK) return error_of(database_.get(), code);
    return Statement(database_.get(), statement);
}

Status Database::execute(const char* sql) const {
    const int code = sqlite3_exec(database_.get(), sql, nullptr, nullptr, nullptr);
    if (code != SQLITE_OK) return error_of(database_.get(), code);
    return Nothing{};
}

Result<std::int64_t> Database::query_number(const char* sql) const {
    auto statement = prepare(sql);
    if (!statement) return statement.error();
    const auto row = statement->step();
    if (!row) return row.error();
    return *row ? statement->number(0) : 0;
}

Result<Transaction> Transaction::begin(const Database& database) {
    if (auto status = database.execute("BEGIN IMMEDIATE"); !status) return status.error();
    return Transaction(database);
}

Transaction::~Transaction() {
    if (database_) static_cast<void>(database_->execute("ROLLBACK"));
}

Status Transaction::commit() {
    auto status = database_->execute("COMMIT");
    if (status) database_ = nullptr;
    return status;
}

}  // namespace lodestream::store
