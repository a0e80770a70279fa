#include "server/store/store.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <random>
#include <set>
#include <tuple>

#include "server/store/files.h"
#include "server/store/sqlite.h"

namespace lodestream::store {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t schema_version = 2;
constexpr std::size_t max_key_length = 1024;  // bytes of ids, names and keys
constexpr std::size_t max_extension_length = 8;
constexpr std::size_t hash_length = 64;
constexpr const char* baked_key = "bake";  // without this content an asset cannot be cut

constexpr const char* schema = R"(
    CREATE TABLE asset(id TEXT PRIMARY KEY, name TEXT NOT NULL UNIQUE, json TEXT NOT NULL) WITHOUT ROWID;
    CREATE TABLE content(
        asset TEXT NOT NULL REFERENCES asset(id) ON DELETE CASCADE,
        key TEXT NOT NULL,
        hash TEXT NOT NULL,
        extension TEXT NOT NULL,
        bytes INTEGER NOT NULL,
        record TEXT NOT NULL,
        PRIMARY KEY(asset, key)) WITHOUT ROWID;
    CREATE INDEX content_by_hash ON content(hash, extension);
    PRAGMA user_version = 1;
)";
constexpr const char* second_schema = R"(
    CREATE TABLE node(
        asset TEXT NOT NULL REFERENCES asset(id) ON DELETE CASCADE,
        node INTEGER NOT NULL,
        state TEXT NOT NULL,
        PRIMARY KEY(asset, node)) WITHOUT ROWID;
    PRAGMA user_version = 2;
)";

bool is_lower_alphanumeric(char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z');
}

bool is_extension(std::string_view text) {
    return !text.empty() && text.size() <= max_extension_length &&
           std::all_of(text.begin(), text.end(), is_lower_alphanumeric);
}

bool is_hash(std::string_view text) {
    return text.size() == hash_length && std::all_of(text.begin(), text.end(), [](char c) {
               return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
           });
}

Status check_text(const char* what, std::string_view text) {
    if (text.empty()) return invalid_input(std::string(what) + " must not be empty");
    if (text.size() > max_key_length)
        return invalid_input(std::string(what) + " is longer than " + std::to_string(max_key_length) + " bytes");
    if (std::any_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }))
        return invalid_input(std::string(what) + " has a control character");
    return Nothing{};
}

Error no_such_asset(std::string_view id) {
    return fail(ErrorCode::not_found, "no asset \"" + std::string(id) + "\"");
}

Error no_such_content(std::string_view asset_id, std::string_view key) {
    return fail(ErrorCode::not_found,
                "asset \"" + std::string(asset_id) + "\" has no content \"" + std::string(key) + "\"");
}

}  // namespace

struct Store::Impl {
    struct FileName {
        std::string hash;
        std::string extension;
        bool operator==(const FileName&) const = default;
        bool operator<(const FileName& other) const {
            return std::tie(hash, extension) < std::tie(other.hash, other.extension);
        }
    };

    fs::path folder;
    FileDescriptor lock;  // shared with the store's other processes while it is open; only who is alone sweeps
    // Reads have a connection of their own, so that they do not wait for the flushes of a write.
    std::optional<Database> write_connection;
    std::optional<Database> read_connection;
    std::mutex write_mutex;
    std::mutex read_mutex;
    const std::string instance =
        std::to_string(std::random_device{}());  // keeps the incoming files of two stores apart
    std::atomic<std::uint64_t> incoming_count{0};
    std::vector<std::string> interrupted;

    Status open();
    Status make_schema();
    Status sweep();
    Status sweep_rows();
    Status sweep_files();
    Status sort_interrupted();
    Result<std::set<FileName>> named_files() const;

    fs::path path_of(const std::string& hash, const std::string& extension) const {
        return folder / "content" / hash.substr(0, 2) / (hash + "." + extension);
    }
    fs::path next_incoming() { return folder / "incoming" / (instance + "-" + std::to_string(incoming_count++)); }

    Result<std::vector<proto::Asset>> select_assets(const Database& database) const;
    Status write_asset(const proto::Asset& asset);
    Result<std::vector<FileName>> files_of(const char* sql, std::string_view asset, std::string_view key);
    Status place(const fs::path& incoming, std::string_view asset, std::string_view key, const FileName& name,
                 std::uint64_t bytes, std::string_view record);
    Status remove_unnamed(const FileName& file);
};

Status Store::Impl::open() {
    std::error_code ignored;
    fs::create_directories(folder, ignored);
    for (const fs::path& path : {folder, folder / "content", folder / "incoming"})
        if (auto status = make_folder(path); !status) return status;
    auto opened = open_lock(folder / "lock");
    if (!opened) return opened.error();
    lock = std::move(*opened);
    const bool alone = try_lock_alone(lock);
    if (!alone)
        if (auto status = lock_shared(lock); !status) return status;
    for (auto* connection : {&write_connection, &read_connection}) {
        auto database = Database::open(folder / "catalogue.sqlite");
        if (!database) return database.error();
        *connection = std::move(*database);
        if (connection == &write_connection)
            if (auto status = make_schema(); !status) return status;
    }
    if (!alone) return Nothing{};
    if (auto status = sweep(); !status) return status;
    return lock_shared(lock);
}

Status Store::Impl::make_schema() {
    auto transaction = Transaction::begin(*write_connection);
    if (!transaction) return transaction.error();
    const auto version = write_connection->query_number("PRAGMA user_version");
    if (!version) return version.error();
    if (*version > schema_version)
        return fail(ErrorCode::conflict, folder.string() + " was made by a newer version: its catalogue has schema " +
                                             std::to_string(*version) + ", this program knows " +
                                             std::to_string(schema_version));
    if (*version < 1)
        if (auto status = write_connection->execute(schema); !status) return status;
    if (*version < 2)
        if (auto status = write_connection->execute(second_schema); !status) return status;
    return transaction->commit();
}

Status Store::Impl::sweep() {
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder / "incoming", error)) fs::remove_all(entry.path(), error);
    if (auto status = sweep_rows(); !status) return status;
    if (auto status = sort_interrupted(); !status) return status;
    return sweep_files();
}

// Rows whose file is missing or has another size go.
Status Store::Impl::sweep_rows() {
    struct Row {
        std::string asset, key;
    };
    std::vector<Row> broken;
    auto select = write_connection->prepare("SELECT asset, key, hash, extension, bytes FROM content");
    if (!select) return select.error();
    for (;;) {
        const auto row = select->step();
        if (!row) return row.error();
        if (!*row) break;
        std::uint64_t bytes = 0;
        const fs::path path = path_of(select->text(2), select->text(3));
        if (!is_regular_file(path, bytes) || bytes != static_cast<std::uint64_t>(select->number(4)))
            broken.push_back({select->text(0), select->text(1)});
    }
    for (const Row& row : broken) {
        auto remove = write_connection->prepare("DELETE FROM content WHERE asset = ? AND key = ?");
        if (!remove) return remove.error();
        if (auto status = remove->bind(row.asset).bind(row.key).run(); !status) return status;
        if (row.key != baked_key) continue;
        auto update = write_connection->prepare(
            "UPDATE asset SET json = json_set(json, '$.status', 'failed', '$.error', 'its baked data is missing; send "
            "it again')"
            " WHERE id = ?");
        if (!update) return update.error();
        if (auto status = update->bind(row.asset).run(); !status) return status;
    }
    return Nothing{};
}

// A crash left assets `baking` that nobody bakes any more: with their imported model they can be gone on with.
Status Store::Impl::sort_interrupted() {
    const auto assets = select_assets(*write_connection);
    if (!assets) return assets.error();
    for (proto::Asset asset : *assets) {
        if (asset.status != proto::AssetStatus::baking) continue;
        auto select = write_connection->prepare("SELECT 1 FROM content WHERE asset = ? AND key = ?");
        if (!select) return select.error();
        const auto kept = select->bind(asset.id).bind(imported_key).step();
        if (!kept) return kept.error();
        if (*kept) {
            interrupted.push_back(asset.id);
            continue;
        }
        asset.status = proto::AssetStatus::failed;
        asset.error = "the server stopped during the bake; send it again";
        if (auto status = write_asset(asset); !status) return status;
    }
    return Nothing{};
}

// Files that no row names go.
Status Store::Impl::sweep_files() {
    const auto named = named_files();
    if (!named) return named.error();
    std::error_code error;
    std::vector<fs::path> unnamed;
    for (fs::recursive_directory_iterator it(folder / "content", error), end; it != end; it.increment(error)) {
        if (error) return fail(ErrorCode::io, "cannot read " + (folder / "content").string() + ": " + error.message());
        if (it->is_directory(error) && !it->is_symlink(error)) continue;
        const std::string extension = it->path().extension().string();
        const FileName name{it->path().stem().string(), extension.empty() ? "" : extension.substr(1)};
        if (!named->contains(name) || it->path() != path_of(name.hash, name.extension)) unnamed.push_back(it->path());
    }
    if (error) return fail(ErrorCode::io, "cannot read " + (folder / "content").string() + ": " + error.message());
    for (const fs::path& path : unnamed) fs::remove(path, error);
    return Nothing{};
}

Result<std::set<Store::Impl::FileName>> Store::Impl::named_files() const {
    std::set<FileName> names;
    auto select = write_connection->prepare("SELECT DISTINCT hash, extension FROM content");
    if (!select) return select.error();
    for (;;) {
        const auto row = select->step();
        if (!row) return row.error();
        if (!*row) return names;
        names.insert({select->text(0), select->text(1)});
    }
}

Result<std::vector<proto::Asset>> Store::Impl::select_assets(const Database& database) const {
    std::vector<proto::Asset> assets;
    auto select = database.prepare("SELECT json FROM asset ORDER BY name, id");
    if (!select) return select.error();
    for (;;) {
        const auto row = select->step();
        if (!row) return row.error();
        if (!*row) return assets;
        auto asset = proto::parse_asset(select->text(0));
        if (!asset)
            return fail(ErrorCode::internal, "the catalogue holds an unreadable asset: " + asset.error().message);
        assets.push_back(std::move(*asset));
    }
}

Status Store::Impl::write_asset(const proto::Asset& asset) {
    auto upsert = write_connection->prepare(
        "INSERT INTO asset(id, name, json) VALUES(?, ?, ?)"
        " ON CONFLICT(id) DO UPDATE SET name = excluded.name, json = excluded.json");
    if (!upsert) return upsert.error();
    auto status = upsert->bind(asset.id).bind(asset.name).bind(proto::to_json(asset)).run();
    if (!status && status.error().code == ErrorCode::conflict)
        return fail(ErrorCode::conflict, "the name \"" + asset.name + "\" is taken by another asset");
    return status;
}

Result<std::vector<Store::Impl::FileName>> Store::Impl::files_of(const char* sql, std::string_view asset,
                                                                 std::string_view key) {
    std::vector<FileName> files;
    auto select = write_connection->prepare(sql);
    if (!select) return select.error();
    select->bind(asset);
    if (!key.empty()) select->bind(key);
    for (;;) {
        const auto row = select->step();
        if (!row) return row.error();
        if (!*row) return files;
        files.push_back({select->text(0), select->text(1)});
    }
}

// Renames a written file into place and names it, both under the catalogue's write lock, so that no one removes it
// between.
Status Store::Impl::place(const fs::path& incoming, std::string_view asset, std::string_view key, const FileName& name,
                          std::uint64_t bytes, std::string_view record) {
    auto transaction = Transaction::begin(*write_connection);
    if (!transaction) return transaction.error();
    auto known = write_connection->prepare("SELECT 1 FROM asset WHERE id = ?");
    if (!known) return known.error();
    const auto row = known->bind(asset).step();
    if (!row) return row.error();
    if (!*row) return no_such_asset(asset);
    static_cast<void>(known->step());

    const fs::path path = path_of(name.hash, name.extension);
    if (auto status = make_folder(path.parent_path()); !status) return status;
    if (auto status = rename_file(incoming, path); !status) return status;
    if (auto status = flush_folder(path.parent_path()); !status) return status;
    auto upsert = write_connection->prepare(
        "INSERT OR REPLACE INTO content(asset, key, hash, extension, bytes, record) VALUES(?, ?, ?, ?, ?, ?)");
    if (!upsert) return upsert.error();
    upsert->bind(asset)
        .bind(key)
        .bind(name.hash)
        .bind(name.extension)
        .bind(static_cast<std::int64_t>(bytes))
        .bind(record);
    if (auto status = upsert->run(); !status) return status;
    return transaction->commit();
}

// Removes a file unless a row names it; the write lock keeps others from naming it meanwhile.
Status Store::Impl::remove_unnamed(const FileName& file) {
    auto transaction = Transaction::begin(*write_connection);
    if (!transaction) return transaction.error();
    auto select = write_connection->prepare("SELECT 1 FROM content WHERE hash = ? AND extension = ?");
    if (!select) return select.error();
    const auto named = select->bind(file.hash).bind(file.extension).step();
    if (!named) return named.error();
    std::error_code error;
    if (!*named) fs::remove(path_of(file.hash, file.extension), error);
    return Nothing{};
}

Store::Store(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Store::~Store() = default;
Store::Store(Store&&) noexcept = default;
Store& Store::operator=(Store&&) noexcept = default;

Result<Store> Store::open(const fs::path& folder) try {
    auto impl = std::make_unique<Impl>();
    impl->folder = folder;
    if (auto status = impl->open(); !status)
        return fail(status.error().code, "cannot open the store: " + status.error().message);
    return Store(std::move(impl));
} catch (const std::exception& e) {
    return fail(ErrorCode::io, "cannot open the store " + folder.string() + ": " + e.what());
}

Status Store::put_asset(const proto::Asset& asset) {
    if (auto status = check_text("an asset's id", asset.id); !status) return status;
    if (auto status = check_text("an asset's name", asset.name); !status) return status;
    const std::lock_guard guard(impl_->write_mutex);
    return impl_->write_asset(asset);
}

Result<proto::Asset> Store::asset(std::string_view id_or_name) const {
    const std::lock_guard guard(impl_->read_mutex);
    auto select = impl_->read_connection->prepare(
        "SELECT json FROM asset WHERE id = ?1 OR name = ?1 ORDER BY id = ?1 DESC LIMIT 1");
    if (!select) return select.error();
    const auto row = select->bind(id_or_name).step();
    if (!row) return row.error();
    if (!*row) return no_such_asset(id_or_name);
    return proto::parse_asset(select->text(0));
}

Result<std::vector<proto::Asset>> Store::assets() const {
    const std::lock_guard guard(impl_->read_mutex);
    return impl_->select_assets(*impl_->read_connection);
}

Status Store::remove_asset(std::string_view id) {
    const std::lock_guard guard(impl_->write_mutex);
    std::vector<Impl::FileName> files;
    {
        auto transaction = Transaction::begin(*impl_->write_connection);
        if (!transaction) return transaction.error();
        auto owned = impl_->files_of("SELECT DISTINCT hash, extension FROM content WHERE asset = ?", id, {});
        if (!owned) return owned.error();
        files = std::move(*owned);
        auto remove = impl_->write_connection->prepare("DELETE FROM asset WHERE id = ? RETURNING 1");
        if (!remove) return remove.error();
        const auto removed = remove->bind(id).step();
        if (!removed) return removed.error();
        if (!*removed) return no_such_asset(id);
        static_cast<void>(remove->step());
        if (auto status = transaction->commit(); !status) return status;
    }
    for (const Impl::FileName& file : files)
        if (auto status = impl_->remove_unnamed(file); !status) return status;
    return Nothing{};
}

Result<StoredFile> Store::put_content(std::string_view asset_id, std::string_view key, std::string_view extension,
                                      std::span<const std::byte> bytes, std::string_view record) {
    if (auto status = check_text("a content's key", key); !status) return status.error();
    if (!is_extension(extension)) return invalid_input("an extension must be 1 to 8 lower-case letters or digits");
    const Impl::FileName name{sha256_hex(bytes), std::string(extension)};
    const fs::path incoming = impl_->next_incoming();
    if (auto status = write_and_flush(incoming, bytes); !status) return status.error();

    const std::lock_guard guard(impl_->write_mutex);
    auto replaced = impl_->files_of("SELECT hash, extension FROM content WHERE asset = ? AND key = ?", asset_id, key);
    if (!replaced) return replaced.error();
    if (auto status = impl_->place(incoming, asset_id, key, name, bytes.size(), record); !status) {
        ::unlink(incoming.c_str());
        return status.error();
    }
    for (const Impl::FileName& file : *replaced)
        if (file != name)
            if (auto status = impl_->remove_unnamed(file); !status) return status.error();
    return StoredFile{name.hash, bytes.size(), impl_->path_of(name.hash, name.extension)};
}

Result<Store::Content> Store::content(std::string_view asset_id, std::string_view key) const {
    const std::lock_guard guard(impl_->read_mutex);
    auto select = impl_->read_connection->prepare(
        "SELECT hash, extension, bytes, record FROM content WHERE asset = ? AND key = ?");
    if (!select) return select.error();
    const auto row = select->bind(asset_id).bind(key).step();
    if (!row) return row.error();
    if (!*row) return no_such_content(asset_id, key);
    Content content;
    content.file.hash = select->text(0);
    content.file.bytes = static_cast<std::uint64_t>(select->number(2));
    content.file.path = impl_->path_of(content.file.hash, select->text(1));
    content.record = select->text(3);
    return content;
}

Status Store::set_record(std::string_view asset_id, std::string_view key, std::string_view record) {
    const std::lock_guard guard(impl_->write_mutex);
    auto update =
        impl_->write_connection->prepare("UPDATE content SET record = ? WHERE asset = ? AND key = ? RETURNING 1");
    if (!update) return update.error();
    const auto updated = update->bind(record).bind(asset_id).bind(key).step();
    if (!updated) return updated.error();
    if (!*updated) return no_such_content(asset_id, key);
    return update->run();
}

Status Store::remove_content(std::string_view asset_id, std::string_view key) {
    const std::lock_guard guard(impl_->write_mutex);
    const auto files =
        impl_->files_of("SELECT hash, extension FROM content WHERE asset = ? AND key = ?", asset_id, key);
    if (!files) return files.error();
    auto remove = impl_->write_connection->prepare("DELETE FROM content WHERE asset = ? AND key = ?");
    if (!remove) return remove.error();
    if (auto status = remove->bind(asset_id).bind(key).run(); !status) return status;
    for (const Impl::FileName& file : *files)
        if (auto status = impl_->remove_unnamed(file); !status) return status;
    return Nothing{};
}

Status Store::put_nodes(std::string_view asset_id, std::span<const Node> nodes) {
    const std::lock_guard guard(impl_->write_mutex);
    auto transaction = Transaction::begin(*impl_->write_connection);
    if (!transaction) return transaction.error();
    for (const Node& node : nodes) {
        auto upsert = impl_->write_connection->prepare(
            "INSERT OR REPLACE INTO node(asset, node, state) SELECT id, ?2, ?3 FROM asset WHERE id = ?1 RETURNING 1");
        if (!upsert) return upsert.error();
        const auto written = upsert->bind(asset_id).bind(std::int64_t{node.node}).bind(node.state).step();
        if (!written) return written.error();
        if (!*written) return no_such_asset(asset_id);
        if (auto status = upsert->run(); !status) return status;
    }
    return transaction->commit();
}

Result<std::vector<Store::Node>> Store::nodes(std::string_view asset_id) const {
    const std::lock_guard guard(impl_->read_mutex);
    std::vector<Node> nodes;
    auto select = impl_->read_connection->prepare("SELECT node, state FROM node WHERE asset = ? ORDER BY node");
    if (!select) return select.error();
    select->bind(asset_id);
    for (;;) {
        const auto row = select->step();
        if (!row) return row.error();
        if (!*row) return nodes;
        nodes.push_back({static_cast<std::uint32_t>(select->number(0)), select->text(1)});
    }
}

Result<bool> Store::has_nodes(std::string_view asset_id) const {
    const std::lock_guard guard(impl_->read_mutex);
    auto select = impl_->read_connection->prepare("SELECT 1 FROM node WHERE asset = ? LIMIT 1");
    if (!select) return select.error();
    return select->bind(asset_id).step();
}

Result<StoredFile> Store::put_transient(std::string_view extension, std::span<const std::byte> bytes) {
    if (!is_extension(extension)) return invalid_input("an extension must be 1 to 8 lower-case letters or digits");
    const std::string hash = sha256_hex(bytes);
    const fs::path path = impl_->path_of(hash, std::string(extension)), incoming = impl_->next_incoming();
    if (auto status = write_file(incoming, bytes); !status) return status.error();
    const std::lock_guard guard(impl_->write_mutex);
    auto status = make_folder(path.parent_path());
    if (std::uint64_t there = 0; status && !(is_regular_file(path, there) && there == bytes.size()))
        status = rename_file(incoming, path);
    ::unlink(incoming.c_str());
    if (!status) return status.error();
    return StoredFile{hash, bytes.size(), path};
}

Status Store::remove_transient(const std::string& hash, const std::string& extension) {
    const std::lock_guard guard(impl_->write_mutex);
    return impl_->remove_unnamed({hash, extension});
}

const std::vector<std::string>& Store::interrupted() const {
    return impl_->interrupted;
}

// The name is the proof: a file is renamed to its hash only when it is whole, so the catalogue need not be asked.
Result<StoredFile> Store::file(std::string_view hash, std::string_view extension) const {
    const auto missing = fail(ErrorCode::not_found, "no content of this hash");
    if (!is_hash(hash) || !is_extension(extension)) return missing;
    StoredFile file{std::string(hash), 0, impl_->path_of(std::string(hash), std::string(extension))};
    if (!is_regular_file(file.path, file.bytes)) return missing;
    return file;
}

Status Store::check() const {
    const fs::path probe = impl_->next_incoming();
    if (auto status = write_and_flush(probe, {}); !status) return status;
    ::unlink(probe.c_str());
    const std::lock_guard guard(impl_->read_mutex);
    const auto answer = impl_->read_connection->query_number("SELECT count(*) FROM asset");
    if (!answer) return answer.error();
    return Nothing{};
}

}  // namespace lodestream::store
