#pragma once
// Headers of PLY files. Internal to the loader.
#include "viscache/formats/loading.h"

namespace viscache::loading::ply {

enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

struct Property {
    std::string name;
    Type type = Type::kFloat;
    bool is_list = false;
    Type count_type = Type::kUint8;
    size_t line = 0;  ///< of the header
    bool is_read = false;
};

struct Element {
    std::string name;
    uint64_t count = 0;
    size_t line = 0;  ///< of the header
    std::vector<Property> properties;
    bool is_read = false;
};

struct PlyHeader {
    bool ascii = false, big_endian = false;
    std::vector<Element> elements;
    size_t end = 0;           ///< byte offset of the data
    size_t lines = 0;         ///< number of header lines
    size_t texture_line = 0;  ///< that names a picture; 0: none does
};

/// Size of a stored value in bytes.
size_t size_of(Type t);
PlyHeader read_ply_header(std::string_view text, const std::string& path);

}  // namespace viscache::loading::ply
