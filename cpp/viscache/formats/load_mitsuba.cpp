// Mitsuba XML: files, includes, ids, and the elements of a scene.
#include <filesystem>

#include "viscache/formats/mitsuba_reader.h"

namespace viscache::loading {

MitsubaReader::XmlFile& MitsubaReader::open(const std::string& path, const std::string& asked_at) {
    for (const std::string& outer : open_)
        if (outer == path) fail(asked_at, "the include of '" + path + "' is cyclic");
    // Two includes of the next file in each file make 2^depth files without any cycle, hence both limits.
    if (open_.size() >= size_t(kMaxDepth)) fail(asked_at, "includes are nested too deeply");
    if (files_.size() >= kMaxFiles) fail(asked_at, "the scene includes more than 10,000 files");
    // Nodes and line indices point into the file's text and document, so a file never moves in memory.
    files_.push_back(std::make_unique<XmlFile>(path, read_file(path, asked_at)));
    XmlFile& file = *files_.back();
    const auto result = file.document.load_buffer(file.text.data(), file.text.size());
    if (!result)
        fail(at_line(path, file.lines.line(size_t(std::max<std::ptrdiff_t>(result.offset, 0)))),
             std::string("not well-formed XML: ") + result.description());
    open_.push_back(path);
    return file;
}

MitsubaReader::XmlFile& MitsubaReader::file_of(Node node) const {
    // A reference may lead into another file; errors name the file that holds the element.
    if (last_ && node.root() == last_->document) return *last_;
    for (const auto& file : files_)
        if (node.root() == file->document) return *(last_ = file.get());
    return *files_.front();
}

std::string MitsubaReader::where(Node node) const {
    const XmlFile& file = file_of(node);
    return at_line(file.path, file.lines.line(offset_of(node)));
}

MitsubaReader::Node MitsubaReader::target_of(Node ref) const {
    const std::string id = attribute(ref, "id");
    const auto found = ids_.find(id);
    if (found == ids_.end()) fail_at(ref, "nothing has the id '" + id + "'");
    return found->second;
}

std::string MitsubaReader::path_of(Node owner) const {
    const Node name = property(owner, "filename");
    if (!name) fail_at(owner, "'" + type_of(owner) + "' needs a filename");
    const std::string value = attribute(name, "value");
    if (value.empty()) fail_at(name, "the filename is empty");
    return find_file(value, owner);
}

std::string MitsubaReader::find_file(const std::string& name, Node asker) const {
    std::error_code error;
    const auto is_there = [&](const std::string& path) { return std::filesystem::exists(path, error); };
    // Mitsuba's order: the <path> elements, the latest first, then the folder of the main file. Files that
    // were moved together with an included file are found beside it.
    for (size_t i = folders_.size(); i-- > 0;)
        if (const std::string path = resolve(folders_[i], name); is_there(path)) return path;
    const std::string from_main = resolve(files_.front()->path, name);
    const std::string from_here = resolve(file_of(asker).path, name);
    return !is_there(from_main) && is_there(from_here) ? from_here : from_main;
}

void MitsubaReader::add_folder(Node node) {
    const std::string folder = find_file(attribute(node, "value"), node);
    std::error_code error;
    if (!std::filesystem::is_directory(folder, error))
        return warn_at(node, "the folder '" + folder + "' is not there; skipped");
    folders_.push_back(folder + "/");
}

void MitsubaReader::register_ids(Node root) {
    // Document order without recursion: files may nest to any depth.
    Node node = root;
    for (int depth = 0;;) {
        if (node.attribute("id") && std::string_view(node.name()) != "ref")
            // The first element of an id keeps it.
            ids_.try_emplace(node.attribute("id").value(), node);
        if (node.first_child()) {
            node = node.first_child();
            if (++depth > kMaxDepth) fail_at(node, "elements are nested more than 64 deep");
            continue;
        }
        while (node != root && !node.next_sibling()) {
            node = node.parent();
            --depth;
        }
        if (node == root) return;
        node = node.next_sibling();
    }
}

void MitsubaReader::include(Node node) {
    const XmlFile& file = open(find_file(attribute(node, "filename"), node), where(node));
    const Node scene = file.document.child("scene");
    if (!scene) fail(file.path, "the root element must be <scene>");
    register_ids(scene);
    read_elements(scene);
    open_.pop_back();
}

void MitsubaReader::read_elements(Node scene) {
    for (const Node node : scene.children()) {
        const std::string_view tag = node.name();
        if (tag == "default") {
            use(node);
            // A <default> holds only where nothing was set before, so the main file overrides those that it
            // includes.
            parameters_.try_emplace(node.attribute("name").value(), attribute(node, "value"));
        } else if (tag == "shape") {
            shape(node);
        } else if (tag == "emitter" || tag == "luminaire") {
            emitter(node);
        } else if (tag == "sensor" || tag == "camera") {
            sensor(node);
        } else if (tag == "include") {
            use(node);
            include(node);
        } else if (tag == "path") {
            use(node);
            add_folder(node);
        } else if (tag == "alias") {
            use(node);
            ids_[attribute(node, "as")] = target_of(node);
        }
    }
}

void MitsubaReader::read_scene(const std::string& path) {
    const XmlFile& file = open(path, "");
    const Node scene = file.document.child("scene");
    if (!scene) fail(path, "the root element must be <scene>");
    // "3.5.0" begins with a number: major and minor. The dialects differ in defaults and in names, by the
    // major version alone.
    const auto version = parse_number(std::string_view(scene.attribute("version").value()).substr(0, 3));
    version_major_ = version ? int(*version) : 3;
    register_ids(scene);
    read_elements(scene);
    // Whether a clip plane cuts anything away is known once all shapes are read.
    check_clip_planes();
    for (const auto& read : files_) warn_of_unread(read->document.child("scene"));
}

void load_mitsuba(const std::string& path, Loading& loading) { MitsubaReader(loading).read_scene(path); }

}  // namespace viscache::loading
