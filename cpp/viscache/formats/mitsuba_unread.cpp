// Mitsuba XML: elements that nobody read.
#include "viscache/formats/mitsuba_reader.h"

namespace viscache::loading {

namespace {

/// What a reader need not ask for, because the picture is right without it. The owner is a tag or a type;
/// names in brackets are tags.
struct LeftOut {
    std::string_view owner, names;
};
constexpr LeftOut kLeftOut[] = {
    // Who renders decides on samples and light paths. What has an id is read where a <ref> asks for it.
    {"scene",
     "<integrator> <sampler> <film> <bsdf> <texture> <spectrum> <rgb> <emitter> <luminaire> <medium>"},
    // How pixels are filtered and stored; values of `Frame` are radiance
    {"film",
     "<rfilter> sample_border high_quality_edges file_format pixel_format component_format compensate"},
    {"film", "banner attach_log label gamma exposure tonemap_method key burn variable digits"},
    // Nothing moves, and a pinhole has no focus
    {"sensor", "<sampler> shutter_open shutter_close focus_distance"},
    {"camera", "<sampler> shutter_open shutter_close focus_distance"},
    {"orthographic", "fov fov_axis focal_length"},  // without an angle
    {"thinlens", "aperture_radius"},                // said of the type
    // How samples are chosen
    {"emitter", "sampling_weight mis_compensation"},
    {"luminaire", "sampling_weight"},
    {"bsdf", "sample_visible specular_sampling_weight main_specular_sampling_rate clearcoat_sampling_rate"},
    {"shape", "silhouette_sampling_weight"},
    // A sensor that measures this shape takes no picture
    {"shape", "<sensor>"},
    // The sun's direction stands in their place where it is given. Skies have the resolution of ours, and
    // suns no disk
    {"emitter", "year month day hour minute second timezone latitude longitude resolution complex_sun"},
    // How pictures are kept in memory
    {"texture", "cache max_anisotropy accel format"},
    {"emitter", "cache"},
};

bool names_it(std::string_view names, pugi::xml_node node) {
    const std::string tag = "<" + std::string(node.name()) + ">";
    while (!names.empty()) {
        const size_t end = std::min(names.find(' '), names.size());
        const std::string_view name = names.substr(0, end);
        if (name == tag || same_name(node.attribute("name").value(), name)) return true;
        names.remove_prefix(std::min(end + 1, names.size()));
    }
    return false;
}

}  // namespace

void MitsubaReader::use_rest(Node owner) const {
    for (const Node child : owner.children()) {
        if (child.type() != pugi::node_element || file_of(child).is_read[offset_of(child)]) continue;
        use(child);
        use_rest(child);
    }
}

void MitsubaReader::skip(Node node, const std::string& what) {
    warn_at(node, what);
    use_rest(node);
}

void MitsubaReader::warn_of_unread(Node owner) {
    const std::string_view tag = owner.name();
    if (tag == "transform") return;  // read as a whole
    const auto left_out = [&](Node child, const std::string& type) {
        return std::ranges::any_of(kLeftOut, [&](const LeftOut& row) {
            return (row.owner == tag || row.owner == type) && names_it(row.names, child);
        });
    };
    for (const Node child : owner.children()) {
        if (child.type() != pugi::node_element) continue;
        if (file_of(child).is_read[offset_of(child)]) {
            warn_of_unread(child);
        } else if (const std::string type = type_of(owner); !left_out(child, type)) {
            const std::string name = child.attribute("name").value();
            warn_at(child,
                    (name.empty() ? "<" + std::string(child.name()) + ">" : "property '" + name + "'") +
                        " of " + std::string(tag) + (type.empty() ? "" : " '" + type + "'") + " is not read");
        }
    }
}

}  // namespace viscache::loading
