#include "proto/gzip.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <limits>
#include <stdexcept>

namespace lodestream::proto {
namespace {

constexpr int gzip_window_bits = 15 + 16;  // the largest window, gzip's header
constexpr int memory_level = 8;            // zlib's default
constexpr int level = 6;                   // likewise

z_stream stream_over(std::string_view bytes) {
    if (bytes.size() > std::numeric_limits<uInt>::max()) throw std::length_error("gzip: more than 4 GiB");
    z_stream stream{};
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));  // zlib does not write there
    stream.avail_in = static_cast<uInt>(bytes.size());
    return stream;
}

class Deflater {
  public:
    explicit Deflater(std::string_view bytes) : stream_(stream_over(bytes)) {
        if (deflateInit2(&stream_, level, Z_DEFLATED, gzip_window_bits, memory_level, Z_DEFAULT_STRATEGY) != Z_OK)
            throw std::bad_alloc();
    }
    ~Deflater() { deflateEnd(&stream_); }
    Deflater(const Deflater&) = delete;
    Deflater& operator=(const Deflater&) = delete;

    std::string run(std::size_t deflated) {
        const uInt all = stream_.avail_in;
        std::string out(deflateBound(&stream_, all) + stored_slack, '\0');
        stream_.next_out = reinterpret_cast<Bytef*>(out.data());
        stream_.avail_out = static_cast<uInt>(out.size());
        if (deflated < all) {
            stream_.avail_in = static_cast<uInt>(deflated);
            const bool is_ready = (deflated == 0 || deflate(&stream_, Z_BLOCK) == Z_OK) &&
                                  deflateParams(&stream_, Z_NO_COMPRESSION, Z_DEFAULT_STRATEGY) == Z_OK;
            if (!is_ready) throw std::logic_error("gzip: the buffer is too small");
            stream_.avail_in += all - static_cast<uInt>(deflated);
        }
        if (deflate(&stream_, Z_FINISH) != Z_STREAM_END) throw std::logic_error("gzip: the buffer is too small");
        out.resize(stream_.total_out);
        return out;
    }

  private:
    static constexpr uLong stored_slack = 256;  // where the level changes

    z_stream stream_;
};

class Inflater {
  public:
    explicit Inflater(std::string_view bytes) : stream_(stream_over(bytes)) {
        if (inflateInit2(&stream_, gzip_window_bits) != Z_OK) throw std::bad_alloc();
    }
    ~Inflater() { inflateEnd(&stream_); }
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;

    Result<std::string> run(std::uint64_t max_bytes) {
        std::string out;
        std::array<char, 1 << 16> chunk;
        for (int status = Z_OK; status != Z_STREAM_END;) {
            stream_.next_out = reinterpret_cast<Bytef*>(chunk.data());
            stream_.avail_out = static_cast<uInt>(chunk.size());
            status = inflate(&stream_, Z_NO_FLUSH);
            if (status != Z_OK && status != Z_STREAM_END) return invalid_input("gzip: damaged or cut off");
            const std::size_t made = chunk.size() - stream_.avail_out;
            if (made > max_bytes - out.size())
                return fail(ErrorCode::limit_exceeded, "gzip: gives more than " + std::to_string(max_bytes) + " bytes");
            out.append(chunk.data(), made);
        }
        if (stream_.avail_in > 0) return invalid_input("gzip: something behind its end");
        return out;
    }

  private:
    z_stream stream_;
};

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
    while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
    return text;
}

bool is_same(std::string_view text, std::string_view lower) {
    return std::equal(text.begin(), text.end(), lower.begin(), lower.end(),
                      [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; });
}

// What ends before `separator`, which goes with it.
std::string_view next_part(std::string_view& text, char separator) {
    const std::size_t end = std::min(text.find(separator), text.size());
    const std::string_view part = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    return part;
}

// 1 where there is none, 0 where it cannot be read.
double weight_of(std::string_view parameters) {
    while (!parameters.empty()) {
        const std::string_view parameter = next_part(parameters, ';');
        if (parameter.size() < 2 || !is_same(parameter.substr(0, 2), "q=")) continue;
        const std::string_view value = parameter.substr(2);
        double weight = 0.0;
        const auto end = value.data() + value.size();
        return std::from_chars(value.data(), end, weight).ptr == end ? weight : 0.0;
    }
    return 1.0;
}

}  // namespace

bool accepts_gzip(std::string_view accept_encoding) {
    double named = -1.0, any = 0.0;
    while (!accept_encoding.empty()) {
        std::string_view parameters = next_part(accept_encoding, ',');
        const std::string_view coding = next_part(parameters, ';');
        if (is_same(coding, "gzip") || is_same(coding, "x-gzip")) named = weight_of(parameters);
        if (coding == "*") any = weight_of(parameters);
    }
    return (named >= 0.0 ? named : any) > 0.0;
}

std::string gzip(std::string_view bytes, std::size_t deflated) {
    return Deflater(bytes).run(deflated);
}

Result<std::string> gunzip(std::string_view bytes, std::uint64_t max_bytes) {
    return Inflater(bytes).run(max_bytes);
}

}  // namespace lodestream::proto
