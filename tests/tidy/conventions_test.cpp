// The conventions of the code base, checked on its text: which folder may see which, who owns a foreign library, what
// stays out of common, and that no file names the machine that it was written on.
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace lodestream {
namespace {

namespace fs = std::filesystem;
using testing::IsEmpty;

struct SourceFile {
    std::string name;    // from the root of the checkout, e.g. "common/mesh/mesh.h"
    std::string folder;  // "common/mesh"
    std::string text;
    std::vector<std::string> ours, foreign;  // included with "" and with <>

    bool is_header() const { return name.ends_with(".h"); }
    std::string layer() const { return name.substr(0, name.find('/')); }
};

const fs::path root = LODESTREAM_SOURCE_DIR;

std::string read(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<std::string> matches(const std::string& text, const std::regex& pattern) {
    std::vector<std::string> result;
    for (std::sregex_iterator it(text.begin(), text.end(), pattern), end; it != end; ++it) result.push_back((*it)[1]);
    return result;
}

SourceFile source_file(const fs::path& file) {
    static const std::regex ours(R"re((?:^|\n)#include "([^"]+)")re"), foreign(R"re((?:^|\n)#include <([^>]+)>)re");
    const fs::path relative = file.lexically_relative(root);
    SourceFile result{relative.generic_string(), relative.parent_path().generic_string(), read(file), {}, {}};
    result.ours = matches(result.text, ours);
    result.foreign = matches(result.text, foreign);
    return result;
}

// Every C++ source of the product.
const std::vector<SourceFile>& product() {
    static const std::vector<SourceFile> files = [] {
        std::vector<SourceFile> found;
        for (const char* layer : {"common", "proto", "server", "client"})
            for (const auto& entry : fs::recursive_directory_iterator(root / layer))
                if (entry.path().extension() == ".h" || entry.path().extension() == ".cpp")
                    found.push_back(source_file(entry.path()));
        return found;
    }();
    return files;
}

std::string folder_of(const std::string& name) {
    return fs::path(name).parent_path().generic_string();
}

TEST(Conventions, SourcesAreFound) {
    EXPECT_GT(product().size(), 50u);
}

TEST(Conventions, OurIncludesAreGivenFromTheRoot) {
    std::vector<std::string> bad;
    for (const SourceFile& file : product())
        for (const std::string& include : file.ours)
            if (!fs::exists(root / include) || include.starts_with(".") || include.starts_with("/"))
                bad.push_back(file.name + " includes " + include);
    EXPECT_THAT(bad, IsEmpty());
}

TEST(Conventions, ArrowsPointDown) {
    const std::map<std::string, std::set<std::string>> may_see{{"common", {"common"}},
                                                               {"proto", {"proto", "common"}},
                                                               {"server", {"server", "proto", "common"}},
                                                               {"client", {"client", "proto", "common"}}};
    std::vector<std::string> bad;
    for (const SourceFile& file : product())
        for (const std::string& include : file.ours)
            if (!may_see.at(file.layer()).contains(include.substr(0, include.find('/'))))
                bad.push_back(file.name + " includes " + include);
    EXPECT_THAT(bad, IsEmpty());
}

using Graph = std::map<std::string, std::set<std::string>>;

// The first cycle met from `node`, as "a -> b -> a"; empty where there is none.
std::string cycle_from(const Graph& graph, const std::string& node, std::vector<std::string>& path,
                       std::set<std::string>& done) {
    const auto again = std::find(path.begin(), path.end(), node);
    if (again != path.end()) {
        std::string text;
        for (auto it = again; it != path.end(); ++it) text += *it + " -> ";
        return text + node;
    }
    if (done.contains(node)) return "";
    path.push_back(node);
    if (const auto entry = graph.find(node); entry != graph.end())
        for (const std::string& next : entry->second)
            if (std::string cycle = cycle_from(graph, next, path, done); !cycle.empty()) return cycle;
    path.pop_back();
    done.insert(node);
    return "";
}

std::string first_cycle(const Graph& graph) {
    std::set<std::string> done;
    for (const auto& [node, next] : graph) {
        std::vector<std::string> path;
        if (std::string cycle = cycle_from(graph, node, path, done); !cycle.empty()) return cycle;
    }
    return "";
}

TEST(Conventions, FirstCycleFindsOne) {
    EXPECT_EQ(first_cycle({{"a", {"b"}}, {"b", {"c", "d"}}, {"c", {}}, {"d", {"b"}}}), "b -> d -> b");
    EXPECT_EQ(first_cycle({{"a", {"b", "c"}}, {"b", {"d"}}, {"c", {"d"}}}), "");
}

TEST(Conventions, NoFolderSeesItselfThroughAnother) {
    Graph folders;
    for (const SourceFile& file : product())
        for (const std::string& include : file.ours)
            if (folder_of(include) != file.folder) folders[file.folder].insert(folder_of(include));
    EXPECT_EQ(first_cycle(folders), "");
}

struct Ownership {
    std::string_view prefix;
    std::vector<std::string_view> owners;
};

const std::vector<Ownership>& owners() {
    static const std::vector<Ownership> table{
        {"glm/", {"common/base"}},
        {"OpenMesh/", {"common/simplify"}},
        {"draco/", {"common/codec"}},
        {"nlohmann/", {"proto", "common/codec"}},
        {"yaml-cpp/", {"proto"}},
        {"zlib", {"proto"}},
        {"tiny_gltf", {"server/importer"}},
        {"tiny_obj_loader", {"server/importer"}},
        {"meshoptimizer", {"common/codec", "server/importer", "client/render"}},
        {"stb/", {"common/image"}},
        {"sqlite3", {"server/store"}},
        {"openssl/", {"server/store"}},
        {"minizip/", {"server/store"}},
        {"boost/", {"server/http", "client/sdk"}},
        {"EGL/", {"client/render"}},
        {"GLES", {"client/render"}},
        {"CLI/", {"server", "client"}},
    };
    return table;
}

const Ownership* ownership(const std::string& include) {
    for (const Ownership& entry : owners())
        if (include.starts_with(entry.prefix)) return &entry;
    return nullptr;
}

bool is_system_header(const std::string& include) {
    static const std::set<std::string> c_library{"unistd.h", "fcntl.h",  "signal.h", "poll.h",
                                                 "netdb.h",  "malloc.h", "sched.h"};
    return include.find_first_of("./") == std::string::npos || include.starts_with("sys/") ||
           include.starts_with("netinet/") || include.starts_with("arpa/") || c_library.contains(include);
}

TEST(Conventions, AForeignLibraryIsIncludedByItsOwnersAlone) {
    std::vector<std::string> bad;
    for (const SourceFile& file : product())
        for (const std::string& include : file.foreign) {
            if (is_system_header(include)) continue;
            const Ownership* entry = ownership(include);
            if (entry == nullptr || std::ranges::count(entry->owners, file.folder) == 0)
                bad.push_back(file.name + " includes " + include);
        }
    EXPECT_THAT(bad, IsEmpty());
}

// Headers that another folder includes, and all of their own folder that those include in turn.
std::set<std::string> headers_seen_from_outside() {
    std::map<std::string, const SourceFile*> by_name;
    for (const SourceFile& file : product()) by_name[file.name] = &file;
    std::vector<std::string> open;
    for (const SourceFile& file : product())
        for (const std::string& include : file.ours)
            if (folder_of(include) != file.folder) open.push_back(include);
    std::set<std::string> seen;
    while (!open.empty()) {
        const std::string name = open.back();
        open.pop_back();
        if (!by_name.contains(name) || !seen.insert(name).second) continue;
        open.insert(open.end(), by_name[name]->ours.begin(), by_name[name]->ours.end());
    }
    return seen;
}

TEST(Conventions, NoHeaderThatOthersIncludeNamesAForeignLibrary) {
    const std::set<std::string> outside = headers_seen_from_outside();
    std::vector<std::string> bad;
    for (const SourceFile& file : product())
        for (const std::string& include : file.foreign)
            if (outside.contains(file.name) && ownership(include) != nullptr && file.name != "common/base/math.h")
                bad.push_back(file.name + " includes " + include);
    EXPECT_THAT(bad, IsEmpty());
}

TEST(Conventions, CommonHasNoThreadsFilesSocketsOrClock) {
    const std::set<std::string> forbidden{"thread",     "mutex",         "future",   "condition_variable",
                                          "filesystem", "fstream",       "iostream", "chrono",
                                          "ctime",      "random_device", "unistd.h", "fcntl.h",
                                          "stop_token", "shared_mutex",  "semaphore"};
    std::vector<std::string> bad;
    for (const SourceFile& file : product())
        for (const std::string& include : file.foreign)
            if (file.layer() == "common" &&
                (forbidden.contains(include) || include.starts_with("sys/") || include.starts_with("netinet/")))
                bad.push_back(file.name + " includes " + include);
    EXPECT_THAT(bad, IsEmpty());
}

TEST(Conventions, HeadersAreGuardedAndFilesAreInSnakeCase) {
    static const std::regex snake_case(R"([a-z][a-z0-9_]*\.(h|cpp))");
    std::vector<std::string> bad;
    for (const SourceFile& file : product()) {
        if (file.is_header() && file.text.find("#pragma once\n") == std::string::npos)
            bad.push_back(file.name + " has no #pragma once");
        if (!std::regex_match(fs::path(file.name).filename().string(), snake_case))
            bad.push_back(file.name + " is not in snake_case");
    }
    EXPECT_THAT(bad, IsEmpty());
}

TEST(Conventions, NoHeaderOpensANamespaceForItsReaders) {
    std::vector<std::string> bad;
    for (const SourceFile& file : product())
        if (file.is_header() && file.text.find("\nusing namespace") != std::string::npos) bad.push_back(file.name);
    EXPECT_THAT(bad, IsEmpty());
}

// Everything that is committed: the tree without what is built, installed or hidden (.git is a file in a work tree).
std::vector<fs::path> all_files() {
    static const std::set<std::string> left_out{"build", "node_modules", ".git", ".cache"};
    std::vector<fs::path> files;
    for (fs::recursive_directory_iterator it(root), end; it != end; ++it) {
        if (left_out.contains(it->path().filename().string())) {
            if (it->is_directory()) it.disable_recursion_pending();
        } else if (it->is_regular_file()) {
            files.push_back(it->path());
        }
    }
    return files;
}

TEST(Conventions, NoFileNamesAMachineOrARegistry) {
    // Written in two halves, so that this file does not find itself.
    const std::array<std::string, 4> machine{std::string("/wo") + "rk/", std::string("/ho") + "me/",
                                             std::string("registry.np") + "mjs", std::string("deb.de") + "bian.org"};
    std::vector<std::string> bad;
    for (const fs::path& file : all_files()) {
        const std::string text = read(file);
        for (const std::string& word : machine)
            if (text.find(word) != std::string::npos)
                bad.push_back(file.lexically_relative(root).generic_string() + " contains " + word);
    }
    EXPECT_THAT(bad, IsEmpty());
}

}  // namespace
}  // namespace lodestream
