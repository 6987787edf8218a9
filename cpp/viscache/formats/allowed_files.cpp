#include "viscache/formats/allowed_files.h"

#include <algorithm>
#include <string_view>

#include "viscache/formats/loading.h"

namespace viscache::loading {

namespace {

namespace fs = std::filesystem;

constexpr int kMaxLevelsUp = 2;

/// Names of folders that scenes share, as published collections have them.
constexpr std::string_view kAssetFolders[] = {
    "assets",    "common", "envmaps", "geometry", "hdr",     "hdri",      "hdris", "images",  "maps",
    "materials", "mesh",   "meshes",  "models",   "objects", "resources", "spds",  "texture", "textures"};

thread_local const AllowedFiles* current_rule = nullptr;

/// The path from `folder` down to `file`; empty if the file is not below it.
fs::path below(const fs::path& folder, const fs::path& file) {
    const auto [end, rest] = std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
    fs::path found;
    if (end != folder.end()) return found;
    for (auto part = rest; part != file.end(); ++part) found /= *part;
    return found;
}

bool is_asset_folder(const fs::path& name) {
    return std::ranges::find(kAssetFolders, lower(name.string())) != std::end(kAssetFolders);
}

}  // namespace

AllowedFiles::AllowedFiles(const std::string& main_file, bool allow_outside)
    : main_file_(main_file), outer_(current_rule) {
    std::error_code error;
    folder_ = fs::weakly_canonical(fs::absolute(main_file, error).parent_path(), error);
    current_rule = allow_outside ? nullptr : this;
}

AllowedFiles::~AllowedFiles() { current_rule = outer_; }

const AllowedFiles* AllowedFiles::current() { return current_rule; }

bool AllowedFiles::allows(const std::string& path) const {
    if (path == main_file_) return true;
    std::error_code error;
    const fs::path file = fs::weakly_canonical(fs::absolute(path, error), error);
    if (error) return false;
    if (!below(folder_, file).empty()) return true;
    fs::path above = folder_;
    for (int level = 0; level < kMaxLevelsUp; ++level) {
        above = above.parent_path();
        if (above == above.root_path()) return false;
        if (const fs::path rest = below(above, file); !rest.empty()) return is_asset_folder(*rest.begin());
    }
    return false;
}

}  // namespace viscache::loading
