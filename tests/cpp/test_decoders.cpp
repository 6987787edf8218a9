// formats/decoders.h: every format from hand-made files, and thousands of damaged ones, for the sanitizers.
#include "viscache/formats/decoders.h"

#include <random>

#include "check.h"
#include "viscache/formats/decode_image.h"

namespace viscache::test::decoders_tests {
namespace {

using loading::decode_image;

std::string from_hex(std::string_view digits) {
    std::string bytes;
    for (size_t i = 0; i + 1 < digits.size(); i += 2)
        bytes += char(std::stoi(std::string(digits.substr(i, 2)), nullptr, 16));
    return bytes;
}

/// Pictures of 16 x 16 pixels by libjpeg: baseline and progressive.
const std::string kBaseline = from_hex(
    "ffd8ffdb0043001b12141714111b1716171e1c1b2028422b28252528513a3d3042605565645f555d5b6a7899816a7190735b"
    "5d85b586909ea3abadab6780bcc9baa6c799a8aba4ffdb0043011c1e1e2823284e2b2b4ea46e5d6ea4a4a4a4a4a4a4a4a4a4"
    "a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4ffc00011080010001003"
    "012200021101031101ffc4001500010100000000000000000000000000000504ffc400171000030100000000000000000000"
    "00000000010431ffc40014010100000000000000000000000000000000ffc400161101010100000000000000000000000000"
    "001314ffda000c03010002110311003f0096778273bc099de094ef044cefffd9");
const std::string kProgressive = from_hex(
    "ffd8ffdb0043001b12141714111b1716171e1c1b2028422b28252528513a3d3042605565645f555d5b6a7899816a7190735b"
    "5d85b586909ea3abadab6780bcc9baa6c799a8aba4ffdb0043011c1e1e2823284e2b2b4ea46e5d6ea4a4a4a4a4a4a4a4a4a4"
    "a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4ffc20011080010001003"
    "012200021101031101ffc4001500010100000000000000000000000000000403ffc400140101000000000000000000000000"
    "00000000ffda000c03010002100310000001924893ffc4001510010100000000000000000000000000000002ffda00080101"
    "0001050294a52fffc4001511010100000000000000000000000000000013ffda0008010301013f019bffc400151101010000"
    "0000000000000000000000000012ffda0008010201013f0187ffc40014100100000000000000000000000000000020ffda00"
    "08010100063f021fffc40014100100000000000000000000000000000020ffda0008010100013f2101ffda000c0301000200"
    "030000001073ffc40014110100000000000000000000000000000000ffda0008010301013f103fffc4001411010000000000"
    "0000000000000000000000ffda0008010201013f103fffc400161000030000000000000000000000000000000131ffda0008"
    "010100013f1068341a0d0fffd9");

std::string big_endian(uint32_t v) { return {char(v >> 24), char(v >> 16), char(v >> 8), char(v)}; }
std::string little_endian(uint64_t v, int bytes) {
    std::string out;
    for (int i = 0; i < bytes; ++i) out += char(v >> (8 * i));
    return out;
}

std::string chunk(const std::string& kind, const std::string& data) {
    uint32_t crc = ~0u;
    for (const char c : kind + data) {
        crc ^= uint8_t(c);
        for (int k = 0; k < 8; ++k) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0u);
    }
    return big_endian(uint32_t(data.size())) + kind + data + big_endian(~crc);
}

/// A PNG of 4 x 3 pixels whose rows are stored, not compressed.
std::string png(int depth, int color_type, int row_bytes) {
    std::string rows;
    for (int y = 0; y < 3; ++y) {
        rows += '\0';
        for (int i = 0; i < row_bytes; ++i) rows += char(37 * i + 50 * y);
    }
    uint32_t a = 1, b = 0;
    for (const char c : rows) {
        a = (a + uint8_t(c)) % 65521;
        b = (b + a) % 65521;
    }
    const auto n = uint32_t(rows.size());
    const std::string stored =
        "\x78\x01\x01" + little_endian(n, 2) + little_endian(~n, 2) + rows + big_endian(b << 16 | a);
    const std::string head =
        big_endian(4) + big_endian(3) + std::string{char(depth), char(color_type), 0, 0, 0};
    return "\x89PNG\r\n\x1a\n" + chunk("IHDR", head) + chunk("PLTE", std::string(48, 'p')) +
           chunk("IDAT", stored) + chunk("IEND", "");
}

std::string bmp(int bits, int compression, const std::string& between, const std::string& pixels) {
    const auto start = uint32_t(54 + between.size());
    return "BM" + little_endian(0, 8) + little_endian(start, 4) + little_endian(40, 4) + little_endian(4, 4) +
           little_endian(3, 4) + little_endian(1, 2) + little_endian(uint32_t(bits), 2) +
           little_endian(uint32_t(compression), 4) + std::string(20, '\0') + between + pixels;
}

std::string tga(int type, int map_length, int bits, const std::string& rest) {
    return std::string{0, char(map_length > 0), char(type)} + little_endian(0, 2) +
           little_endian(uint32_t(map_length), 2) + std::string{char(map_length > 0 ? 24 : 0)} +
           little_endian(0, 4) + little_endian(4, 2) + little_endian(3, 2) + std::string{char(bits), 0x20} +
           rest;
}

std::string hdr(const std::string& size, const std::string& pixels) {
    return "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" + size + "\n" + pixels;
}

std::string new_runs(int lines) {
    std::string out;
    for (int y = 0; y < lines; ++y) {
        out += std::string{2, 2, 0, 16};
        for (int c = 0; c < 4; ++c) out += std::string{char(128 + 12), char(130 - c), 4, 1, 2, 3, char(129)};
    }
    return out;
}

/// Files of every kind, and the size of the picture.
struct Seed {
    std::string bytes;
    int width, height, channels;
};

std::vector<Seed> seeds() {
    const std::string colors(200, '\x05');
    return {{kBaseline, 16, 16, 3},
            {kProgressive, 16, 16, 3},
            {png(8, 2, 12), 4, 3, 3},
            {png(16, 6, 32), 4, 3, 4},
            {png(1, 0, 1), 4, 3, 1},
            {png(4, 3, 2), 4, 3, 3},
            {bmp(24, 0, "", colors), 4, 3, 3},
            {bmp(32, 0, "", colors), 4, 3, 4},
            {bmp(16, 3, little_endian(0xf800, 4) + little_endian(0x7e0, 4) + little_endian(31, 4), colors), 4,
             3, 3},
            {bmp(4, 0, std::string(64, 'p'), colors), 4, 3, 3},
            {tga(2, 0, 24, colors), 4, 3, 3},
            {tga(2, 0, 16, colors), 4, 3, 3},
            {tga(1, 9, 8, colors), 4, 3, 3},
            {tga(11, 0, 8, "\x83z\x03wxyz\x83q"), 4, 3, 1},
            {tga(10, 0, 32, "\x87zyxw\x83qrst"), 4, 3, 4},
            {hdr("-Y 3 +X 4", std::string(48, '\x81')), 4, 3, 3},
            {hdr("+X 4 +Y 3", std::string(48, '\x81')), 4, 3, 3},
            {hdr("-Y 2 +X 16", new_runs(2)), 16, 2, 3},
            {hdr("-Y 3 +X 4", "abcd\1\1\1\3abcd\1\1\1\3abcd\1\1\1\3"), 4, 3, 3}};
}

void whole_files_are_read() {
    for (const Seed& seed : seeds()) {
        const Image image = decode_image(seed.bytes, "seed", true);
        check_equal(image.width, seed.width, "width");
        check_equal(image.height, seed.height, "height");
        check_equal(image.channels, seed.channels, "channels");
        check_equal(image.size(), size_t(seed.width) * size_t(seed.height) * size_t(seed.channels), "values");
        check(std::isfinite(sample_image(image, {0.3f, 0.7f}).rgb.x), "a lookup is finite");
    }
}

/// Whether the bytes are a picture; anything else must be a SceneError.
bool is_read(const std::string& bytes) {
    try {
        const Image image = decode_image(bytes, "damaged", true);
        check_equal(image.size(), size_t(image.width) * size_t(image.height) * size_t(image.channels),
                    "values");
        return true;
    } catch (const SceneError&) {
        return false;
    }
}

void files_that_end_too_early_are_refused() {
    for (const Seed& seed : seeds())
        for (size_t n = 0; n < std::min<size_t>(seed.bytes.size(), 40); ++n)
            check(!is_read(seed.bytes.substr(0, n)), "a part of a file is refused");
}

void damaged_files_are_read_or_refused() {
    std::mt19937 dice(5);
    const auto below = [&](size_t n) { return size_t(dice() % n); };
    int n_read = 0, n_refused = 0;
    for (const Seed& seed : seeds())
        for (int i = 0; i < 1500; ++i) {
            std::string bytes = seed.bytes;
            const size_t at = below(bytes.size());
            switch (below(4)) {
                case 0: bytes.resize(at); break;
                case 1: bytes.erase(at, below(32)); break;
                case 2: bytes[at] = char(dice()); break;
                default:
                    for (int k = 0; k < 3; ++k)
                        bytes[below(std::min<size_t>(bytes.size(), 64))] = "\0\1\177\200\377"[below(5)];
            }
            ++(is_read(bytes) ? n_read : n_refused);
        }
    check(n_read > 1000 && n_refused > 1000, "some are read, some refused");
}

void claims_are_refused_before_memory_is_taken() {
    const auto refuses = [](std::string bytes, size_t at, const std::string& claim, const std::string& what) {
        bytes.replace(at, claim.size(), claim);
        try {
            decode_image(bytes, "claim", true);
        } catch (const SceneError& error) {
            check(std::string(error.what()).find("too short for the") != std::string::npos, what);
            return;
        }
        fail(what);
    };
    const std::string big = little_endian(16000, 4), wide = little_endian(60000, 2);
    refuses(seeds()[6].bytes, 18, big + big, "BMP");
    refuses(seeds()[10].bytes, 12, wide + little_endian(4000, 2), "TGA");
    refuses(seeds()[14].bytes, 12, wide + little_endian(4000, 2), "TGA with runs");
    refuses(hdr("-Y 8000 +X 16000", std::string(99, 'x')), 0, "#?", "HDR");
    refuses(kBaseline, kBaseline.find("\xff\xc0") + 5, std::string("\x3e\x80\x3e\x80"), "JPEG");
    refuses(kProgressive, kProgressive.find("\xff\xc2") + 5, std::string("\x3e\x80\x3e\x80"),
            "JPEG in scans");
    std::string head = big_endian(16000) + big_endian(16000) + std::string{8, 2, 0, 0, 0};
    refuses(seeds()[2].bytes, 8, chunk("IHDR", head), "PNG");
}

const Suite suite{
    {"pictures: whole files of every format are read", whole_files_are_read},
    {"pictures: files that end too early are refused", files_that_end_too_early_are_refused},
    {"pictures: damaged files are read or refused", damaged_files_are_read_or_refused},
    {"pictures: claims that the bytes cannot hold are refused", claims_are_refused_before_memory_is_taken}};

}  // namespace
}  // namespace viscache::test::decoders_tests
