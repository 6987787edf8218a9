// JPEG, read by libjpeg-turbo. Its errors come back by longjmp, so that the functions between setjmp and
// libjpeg hold no objects with destructors; what they fill belongs to `decode_jpeg`.
#include <csetjmp>
#include <cstddef>
#include <cstdio>

#include <jpeglib.h>

#include <jerror.h>

#include <algorithm>
#include <array>

#include "viscache/formats/decoders.h"

namespace viscache::loading {

namespace {

constexpr int kMaxScans = 64;  // of progressive files; encoders write up to twenty

struct JpegReader {
    jpeg_decompress_struct jpeg{};
    jpeg_error_mgr errors{};
    jpeg_progress_mgr progress{};
    std::jmp_buf failed;
    std::array<char, JMSG_LENGTH_MAX> message{};

    JpegReader() = default;
    JpegReader(const JpegReader&) = delete;
    ~JpegReader() { jpeg_destroy_decompress(&jpeg); }
};

void on_jpeg_error(j_common_ptr jpeg) {
    auto& reader = *static_cast<JpegReader*>(jpeg->client_data);
    (*jpeg->err->format_message)(jpeg, reader.message.data());
    std::longjmp(reader.failed, 1);
}

/// Data that are damaged or missing are errors; other warnings, of odd but whole files, are not shown.
void on_message(j_common_ptr jpeg, int level) {
    if (level >= 0) return;
    const int code = jpeg->err->msg_code;
    if (code == JWRN_HIT_MARKER || code == JWRN_HUFF_BAD_CODE || code == JWRN_ARITH_BAD_CODE ||
        code == JWRN_JPEG_EOF || code == JWRN_MUST_RESYNC)
        on_jpeg_error(jpeg);
}

void on_output(j_common_ptr) {}

void on_progress(j_common_ptr jpeg) {
    auto& reader = *static_cast<JpegReader*>(jpeg->client_data);
    if (reader.jpeg.input_scan_number <= kMaxScans) return;
    std::snprintf(reader.message.data(), reader.message.size(), "more than %d scans", kMaxScans);
    std::longjmp(reader.failed, 1);
}

/// Up to the pixels, and how they are to be given: grey, RGB or CMYK.
bool read_jpeg_head(JpegReader& reader, std::string_view bytes) {
    jpeg_decompress_struct& jpeg = reader.jpeg;
    jpeg.err = jpeg_std_error(&reader.errors);
    reader.errors.error_exit = on_jpeg_error;
    reader.errors.emit_message = on_message;
    reader.errors.output_message = on_output;
    jpeg.client_data = &reader;
    if (setjmp(reader.failed)) return false;
    jpeg_create_decompress(&jpeg);
    reader.progress.progress_monitor = on_progress;
    jpeg.progress = &reader.progress;
    jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(bytes.data()), (unsigned long)bytes.size());
    jpeg_read_header(&jpeg, TRUE);
    if (jpeg.jpeg_color_space == JCS_CMYK || jpeg.jpeg_color_space == JCS_YCCK)
        jpeg.out_color_space = JCS_CMYK;
    else if (jpeg.num_components == 1)
        jpeg.out_color_space = JCS_GRAYSCALE;
    else
        jpeg.out_color_space = JCS_RGB;
    jpeg_calc_output_dimensions(&jpeg);
    return true;
}

bool read_jpeg_rows(JpegReader& reader, uint8_t* out, size_t row_bytes) {
    if (setjmp(reader.failed)) return false;
    jpeg_start_decompress(&reader.jpeg);
    while (reader.jpeg.output_scanline < reader.jpeg.output_height) {
        JSAMPROW row = out + size_t(reader.jpeg.output_scanline) * row_bytes;
        jpeg_read_scanlines(&reader.jpeg, &row, 1);
    }
    return true;
}

/// The fewest bits of Huffman codes: one for the mean of a block, and one for the end of the block where both
/// are in one scan.
uint64_t least_bits(const jpeg_decompress_struct& jpeg) {
    uint64_t blocks = 0;
    for (int i = 0; i < jpeg.num_components; ++i)
        blocks += uint64_t(jpeg.comp_info[i].width_in_blocks) * jpeg.comp_info[i].height_in_blocks;
    return jpeg.arith_code ? 0 : jpeg.progressive_mode ? blocks : 2 * blocks;
}

/// Ink to light. Adobe's programs store the complement of the inks.
std::vector<uint8_t> without_ink(const std::vector<uint8_t>& inks, bool is_complement) {
    std::vector<uint8_t> rgb(inks.size() / 4 * 3);
    for (size_t i = 0, o = 0; i < inks.size(); i += 4)
        for (size_t c = 0; c < 3; ++c) {
            const int ink = is_complement ? inks[i + c] : 255 - inks[i + c],
                      black = is_complement ? inks[i + 3] : 255 - inks[i + 3];
            rgb[o++] = uint8_t((ink * black + 127) / 255);
        }
    return rgb;
}

}  // namespace

Image decode_jpeg(std::string_view bytes, const std::string& where, bool srgb) {
    JpegReader reader;
    if (!read_jpeg_head(reader, bytes)) fail_broken(where, reader.message.data());
    const jpeg_decompress_struct& jpeg = reader.jpeg;
    const int stored = jpeg.out_color_components;
    Image image = empty_image(jpeg.image_width, jpeg.image_height, std::min(stored, 3), where, srgb);
    check_holds(8 * bytes.size(), least_bits(jpeg), image);
    image.bytes.resize(size_t(image.width) * size_t(image.height) * size_t(stored));
    if (!read_jpeg_rows(reader, image.bytes.data(), size_t(image.width) * size_t(stored)))
        fail_broken(where, reader.message.data());
    if (stored == 4) image.bytes = without_ink(image.bytes, jpeg.saw_Adobe_marker);
    return image;
}

}  // namespace viscache::loading
