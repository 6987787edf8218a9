#pragma once
// Which files a scene may read: a scene from somewhere else must not reach the rest of the disk.
#include <filesystem>
#include <string>

namespace viscache::loading {

/// The files that the scene `main_file` may read. They lie, with links followed, in its folder, or in a
/// folder of assets (`textures`, `hdr`, …) beside its folder or one level higher. While it lives, `read_file`
/// of this thread refuses all others. `main_file` itself may be a link to anywhere.
class AllowedFiles {
public:
    AllowedFiles(const std::string& main_file, bool allow_outside);
    ~AllowedFiles();
    AllowedFiles(const AllowedFiles&) = delete;

    bool allows(const std::string& path) const;
    /// Those of the scene that this thread loads; nullptr: any file may be read.
    static const AllowedFiles* current();

private:
    std::string main_file_;
    std::filesystem::path folder_;
    const AllowedFiles* outer_;
};

}  // namespace viscache::loading
