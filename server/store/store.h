// Content-addressed files plus a SQLite catalogue in one folder:
//
//   DIR/catalogue.sqlite     WAL; assets, and which content each of them made
//   DIR/content/ab/abcd….ext immutable files named by the SHA-256 of their bytes
//   DIR/incoming/            files being written; emptied at start
//
// The catalogue also keeps what clients have changed of a scene's nodes since it was baked.
// A file is written to incoming/, flushed and renamed into place before the catalogue names it, so a crash at any
// instant leaves either nothing or the whole. What the catalogue does not name is swept at start. All calls may come
// from any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "proto/messages.h"

namespace lodestream::store {

inline constexpr std::string_view imported_key = "imported";  // content that lets an interrupted bake go on

struct StoredFile {
    std::string hash;  // 64 lower-case hex digits
    std::uint64_t bytes = 0;
    std::filesystem::path path;
};

class Store {
  public:
    // Creates the folder and the catalogue where missing, sweeps what a crash left: an asset that is `baking` without
    // its imported model becomes `failed`. Errors: io; conflict (made by a newer version).
    static Result<Store> open(const std::filesystem::path& folder);
    ~Store();
    Store(Store&&) noexcept;
    Store& operator=(Store&&) noexcept;

    // Assets. `id` is the store's key; names are unique. The catalogue keeps Asset as its JSON.
    Status put_asset(const proto::Asset& asset);  // insert or replace by id; conflict: name taken by another id
    Result<proto::Asset> asset(std::string_view id_or_name) const;  // not_found
    Result<std::vector<proto::Asset>> assets() const;               // by name
    Status remove_asset(std::string_view id);  // with its keys; files no asset names any more go too

    // Bytes an asset owns under a key unique to it ("bake", "source", "level/1024/…"). Writing the same key again
    // replaces it. `record` is free text kept beside it (JSON of the plan's figures).
    Result<StoredFile> put_content(std::string_view asset_id, std::string_view key, std::string_view extension,
                                   std::span<const std::byte> bytes, std::string_view record = {});
    struct Content {
        StoredFile file;
        std::string record;
    };
    Result<Content> content(std::string_view asset_id, std::string_view key) const;  // not_found

    Status set_record(std::string_view asset_id, std::string_view key, std::string_view record);  // not_found
    // Its file goes too unless it is named elsewhere. What is not there is no error.
    Status remove_content(std::string_view asset_id, std::string_view key);

    // What was changed of a scene's nodes, one text a node; gone with the asset. All of them are written or none.
    // Errors: not_found (asset).
    struct Node {
        std::uint32_t node = 0;
        std::string state;
    };
    Status put_nodes(std::string_view asset_id, std::span<const Node> nodes);
    Result<std::vector<Node>> nodes(std::string_view asset_id) const;  // by number
    Result<bool> has_nodes(std::string_view asset_id) const;

    // Bytes that can be made again: served by their hash like content, but no asset's, not flushed, and swept at the
    // next start. Removing one that content has too leaves it.
    Result<StoredFile> put_transient(std::string_view extension, std::span<const std::byte> bytes);
    Status remove_transient(const std::string& hash, const std::string& extension);

    // The assets that were `baking` with nobody at it when the store was opened; none where another process had it open
    // then, which may be the one that bakes.
    const std::vector<std::string>& interrupted() const;

    // Bytes by their hash, for HTTP. not_found for anything that is not 64 hex digits of a stored file with this
    // extension.
    Result<StoredFile> file(std::string_view hash, std::string_view extension) const;

    // A quick check that the disk takes writes; for /readyz.
    Status check() const;

  private:
    struct Impl;
    explicit Store(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

Result<std::vector<std::byte>> read_file(const std::filesystem::path& path, std::uint64_t max_bytes);

}  // namespace lodestream::store
