// Mitsuba XML: lights.
#include "viscache/formats/mitsuba_reader.h"

namespace viscache::loading {

namespace {

constexpr Rgb kWhite{1, 1, 1};

}  // namespace

/// Radiance of the shape's area lights. One of them may have an image.
ColorTexture MitsubaReader::area_emission(Node shape) {
    ColorTexture sum{{0, 0, 0}};
    for (Node child : shape.children()) {
        const Node given = child;
        if (std::string_view(child.name()) == "ref") child = target_of(child);
        if (const std::string_view tag = child.name(); tag != "emitter" && tag != "luminaire") continue;
        use(given);
        use(child);
        if (const std::string type = type_of(child); type != "area") {
            skip(child, "emitter '" + type + "' on a shape is not modelled; skipped");
            continue;
        }
        const ColorTexture radiance = color_texture(child, "radiance", kWhite);
        if (sum.image >= 0 || (radiance.image >= 0 && max_component(sum.color) > 0)) {
            warn_at(child, "a second area light on a shape is not modelled beside an image; skipped");
            continue;
        }
        sum.color += max({0, 0, 0}, radiance.color);
        sum.image = radiance.image;
    }
    return sum;
}

void MitsubaReader::envmap(Node node) {
    Environment env;
    env.to_world = transform(node);
    const float scale = float(number(node, "scale", 1));
    env.scale = {scale, scale, scale};
    // Pictures of 8 bits are sRGB; those of floats hold radiance whatever this flag says.
    env.image = loading_.add_image(path_of(node), where(node), true);
    loading_.set_environment(env, where(node));
}

void MitsubaReader::spot(Node node) {
    const Affine t = transform(node);
    // Mitsuba's defaults. Between the two angles its falloff is linear in the angle.
    const double outer = number(node, "cutoff_angle", 20), inner = number(node, "beam_width", outer * 3 / 4);
    const Vec3 axis = normalize(t.vector({0, 0, 1}));
    if (!(outer > 0 && outer <= 180)) fail_at(node, "the cutoff angle must be in (0, 180] degrees");
    if (!(inner >= 0 && inner <= outer)) fail_at(node, "the beam width must be in [0, cutoff angle]");
    // normalize gives the zero vector for a zero vector.
    if (length2(axis) == 0) fail_at(node, "the transform of a spot light must not be singular");
    if (property(node, "texture")) warn_at(node, "the texture of a spot light is not modelled; ignored");
    loading_.scene.point_lights.push_back({t.point({0, 0, 0}),
                                           color(node, "intensity", kWhite),
                                           {Falloff::kAngle, axis, std::cos(float(inner) * float(kDegree)),
                                            std::cos(float(outer) * float(kDegree))}});
}

void MitsubaReader::directional(Node node) {
    const auto given = vector(node, "direction");
    const Vec3 travels = given ? *given : transform(node).vector({0, 0, 1});
    if (length2(travels) == 0) fail_at(node, "the direction must not be zero");
    Rgb irradiance = color(node, "irradiance", kWhite);
    // Mitsuba 3 takes the transformed axis with its length, also for cosines
    if (const float l = length(travels); !given && version_major_ >= 2 && std::fabs(l - 1) > 1e-3f) {
        irradiance = irradiance * l;
        warn_at(node,
                "a transform that scales makes the light brighter, as in Mitsuba 3; highlights may differ");
    }
    loading_.scene.directional_lights.push_back({-normalize(travels), irradiance});
}

void MitsubaReader::emitter(Node node) {
    const std::string type = type_of(node);
    if (type == "area") return;  // shines on the shapes that refer to it
    use(node);
    if (type == "point") {
        PointLight light;
        const auto given = vector(node, "position");
        light.position = given ? *given : transform(node).point({0, 0, 0});
        light.intensity = color(node, "intensity", kWhite);
        // The 0.x dialect may give the power Φ instead: I = Φ / 4π for a light that shines all around.
        if (property(node, "power")) light.intensity = color(node, "power", kWhite) / (4 * kPi);
        loading_.scene.point_lights.push_back(light);
    } else if (type == "spot") {
        spot(node);
    } else if (type == "directional") {
        directional(node);
    } else if (type == "constant") {
        Environment env;
        env.scale = color(node, "radiance", kWhite);
        loading_.set_environment(env, where(node));
    } else if (type == "sunsky" || type == "sky" || type == "sun") {
        sky(node, type);
    } else if (type == "envmap") {
        envmap(node);
    } else {
        skip(node, "emitter '" + type + "' is not modelled; skipped");
    }
}

}  // namespace viscache::loading
