#include "viscache/formats/ply_header.h"

namespace viscache::loading::ply {

namespace {

std::optional<Type> type_named(std::string_view s) {
    if (s == "char" || s == "int8") return Type::kInt8;
    if (s == "uchar" || s == "uint8") return Type::kUint8;
    if (s == "short" || s == "int16") return Type::kInt16;
    if (s == "ushort" || s == "uint16") return Type::kUint16;
    if (s == "int" || s == "int32") return Type::kInt32;
    if (s == "uint" || s == "uint32") return Type::kUint32;
    if (s == "float" || s == "float32") return Type::kFloat;
    if (s == "double" || s == "float64") return Type::kDouble;
    return {};
}

std::vector<std::string> words_of(std::string_view line) {
    std::vector<std::string> words;
    for (size_t i = 0; i < line.size();) {
        const size_t begin = line.find_first_not_of(" \t\r", i);
        if (begin == std::string_view::npos) break;
        const size_t end = std::min(line.find_first_of(" \t\r", begin), line.size());
        words.emplace_back(line.substr(begin, end - begin));
        i = end;
    }
    return words;
}

void read_property(PlyHeader& h, const std::vector<std::string>& w, const std::string& where) {
    Property p;
    p.line = h.lines;
    if (h.elements.empty()) fail(where, "a property stands before any element");
    p.is_list = w.size() == 5 && w[1] == "list";
    if (!p.is_list && w.size() != 3) fail(where, "a property must be 'property <type> <name>' or a list");
    const auto type = type_named(w[p.is_list ? 3 : 1]);
    if (!type) fail(where, "unknown property type '" + w[p.is_list ? 3 : 1] + "'");
    p.type = *type;
    p.name = w.back();
    if (p.is_list) {
        const auto count_type = type_named(w[2]);
        if (!count_type || *count_type == Type::kFloat || *count_type == Type::kDouble)
            fail(where, "the count of a list must have an integer type, got '" + w[2] + "'");
        p.count_type = *count_type;
    }
    h.elements.back().properties.push_back(p);
}

/// Reads one header line; returns true at end_header.
bool read_header_line(PlyHeader& h, const std::vector<std::string>& w, bool& has_format,
                      const std::string& where) {
    // obj_info is an older form of comment. MeshLab names pictures in comments.
    if (w.size() > 2 && w[0] == "comment" && w[1] == "TextureFile") h.texture_line = h.lines;
    if (w.empty() || w[0] == "comment" || w[0] == "obj_info") return false;
    if (w[0] == "format") {
        if (w.size() == 3 && w[2] != "1.0") fail(where, "PLY version " + w[2] + "; 1.0 is read");
        if (w.size() != 3 ||
            (w[1] != "ascii" && w[1] != "binary_little_endian" && w[1] != "binary_big_endian"))
            fail(where, "format '" + (w.size() > 1 ? w[1] : "") +
                            "'; ascii, binary_little_endian and binary_big_endian are read");
        h.ascii = w[1] == "ascii";
        h.big_endian = w[1] == "binary_big_endian";
        has_format = true;
    } else if (w[0] == "element") {
        const auto count = w.size() == 3 ? parse_integer(w[2]) : std::nullopt;
        if (!count || *count < 0) fail(where, "an element must be 'element <name> <count>'");
        h.elements.push_back({w[1], uint64_t(*count), h.lines, {}});
    } else if (w[0] == "property") {
        read_property(h, w, where);
    } else if (w[0] == "end_header") {
        return true;
    } else {
        fail(where, "unknown header line '" + w[0].substr(0, 40) + "'");
    }
    return false;
}

}  // namespace

size_t size_of(Type t) {
    switch (t) {
        case Type::kInt8:
        case Type::kUint8: return 1;
        case Type::kInt16:
        case Type::kUint16: return 2;
        case Type::kInt32:
        case Type::kUint32:
        case Type::kFloat: return 4;
        case Type::kDouble: return 8;
    }
    return 1;
}

PlyHeader read_ply_header(std::string_view text, const std::string& path) {
    PlyHeader h;
    bool has_format = false;
    // Editors of Windows put a mark before the text. Old Macs end lines with CR alone.
    const size_t mark = text.starts_with("\xEF\xBB\xBF") ? 3 : 0, first = text.find_first_of("\r\n", mark);
    const bool cr = first != text.npos && text[first] == '\r' && text.substr(first + 1, 1) != "\n";
    const char end_of_line = cr ? '\r' : '\n';
    for (size_t begin = mark;;) {
        const size_t newline = text.find(end_of_line, begin);
        const std::string where = at_line(path, ++h.lines);
        // A binary file without end_header would be searched line by line to its end otherwise.
        if (newline == std::string_view::npos || newline - begin > 4096)
            fail(where, "the PLY header does not end (no end_header)");
        const auto words = words_of(text.substr(begin, newline - begin));
        begin = newline + 1;
        if (h.lines == 1) {
            if (words.size() != 1 || words[0] != "ply")
                fail(where, "not a PLY file: it must start with 'ply'");
        } else if (read_header_line(h, words, has_format, where)) {
            if (!has_format) fail(where, "the PLY header has no format line");
            // The data begin right behind the newline of end_header, in binary files too.
            h.end = begin;
            return h;
        }
    }
}

}  // namespace viscache::loading::ply
