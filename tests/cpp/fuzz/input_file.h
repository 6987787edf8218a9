#pragma once
// The file that a fuzzer writes its input to, for loaders that read files.
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace viscache::fuzz {

/// One folder of this process alone; it goes with the process.
inline const std::filesystem::path& input_folder() {
    static const std::filesystem::path folder = [] {
        auto path = std::filesystem::temp_directory_path() / ("viscache_fuzz_" + std::to_string(getpid()));
        std::filesystem::create_directories(path);
        std::atexit([] {
            std::error_code ignored;
            std::filesystem::remove_all(input_folder(), ignored);
        });
        return path;
    }();
    return folder;
}

inline std::string input_path(const std::string& extension) {
    return (input_folder() / ("input." + extension)).string();
}

inline std::string name_of(const std::string& path) {
    return std::filesystem::path(path).filename().string();
}

inline bool write_file(const std::string& path, std::string_view content) {
    std::ofstream file(path, std::ios::binary | std::ios::trunc);
    file.write(content.data(), std::streamsize(content.size()));
    return bool(file.flush());
}

}  // namespace viscache::fuzz
