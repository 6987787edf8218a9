// Mitsuba XML: lights.
#include "viscache/scene/mitsuba_reader.h"

namespace viscache::loading {

namespace {

constexpr Rgb kWhite{1, 1, 1};

}  // namespace

Rgb MitsubaReader::area_emission(Node shape) {
    Rgb sum{};
    for (Node child : shape.children()) {
        std::string_view tag = child.name();
        if (tag == "ref") {
            child = target_of(child);
            tag = child.name();
        }
        if (tag != "emitter" && tag != "luminaire") continue;
        if (const std::string type = type_of(child); type != "area") {
            warn_at(child, "emitter '" + type + "' on a shape is not modelled; skipped");
            continue;
        }
        sum += max({0, 0, 0}, color(child, "radiance", kWhite));
    }
    return sum;
}

void MitsubaReader::envmap(Node node) {
    Environment env;
    env.to_world = transform(node);
    const float scale = float(number(node, "scale", 1));
    env.scale = {scale, scale, scale};
    env.image = loading_.add_image(path_of(node), where(node), true);
    loading_.set_environment(env, where(node));
}

void MitsubaReader::emitter(Node node) {
    const std::string type = type_of(node);
    if (type == "point") {
        PointLight light;
        light.position = vector(node, "position").value_or(transform(node).point({0, 0, 0}));
        light.intensity = color(node, "intensity", kWhite);
        if (property(node, "power")) light.intensity = color(node, "power", kWhite) / (4 * kPi);
        loading_.scene.point_lights.push_back(light);
    } else if (type == "directional") {
        const Vec3 travels = vector(node, "direction").value_or(transform(node).vector({0, 0, 1}));
        if (length2(travels) == 0) fail_at(node, "the direction must not be zero");
        loading_.scene.directional_lights.push_back({-normalize(travels), color(node, "irradiance", kWhite)});
    } else if (type == "constant") {
        Environment env;
        env.scale = color(node, "radiance", kWhite);
        loading_.set_environment(env, where(node));
    } else if (type == "envmap") {
        envmap(node);
    } else {
        warn_at(node, "emitter '" + type + "' is not modelled; skipped");
    }
}

}  // namespace viscache::loading
