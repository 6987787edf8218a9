// Mitsuba XML: lights and cameras.
#include "viscache/scene/mitsuba_reader.h"

namespace viscache::loading {

namespace {

constexpr float kDegree = kPi / 180.f;
constexpr Rgb kWhite{1, 1, 1};

}  // namespace

/// Radiance of the shape's area lights. One of them may have an image.
ColorTexture MitsubaReader::area_emission(Node shape) {
    ColorTexture sum{{0, 0, 0}};
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
    env.image = loading_.add_image(path_of(node), where(node), true);
    loading_.set_environment(env, where(node));
}

void MitsubaReader::spot(Node node) {
    const Affine t = transform(node);
    const double outer = number(node, "cutoff_angle", 20), inner = number(node, "beam_width", outer * 3 / 4);
    const Vec3 axis = normalize(t.vector({0, 0, 1}));
    if (!(outer > 0 && outer <= 180)) fail_at(node, "the cutoff angle must be in (0, 180] degrees");
    if (!(inner >= 0 && inner <= outer)) fail_at(node, "the beam width must be in [0, cutoff angle]");
    if (length2(axis) == 0) fail_at(node, "the transform of a spot light must not be singular");
    if (property(node, "texture")) warn_at(node, "the texture of a spot light is not modelled; ignored");
    loading_.scene.point_lights.push_back(
        {t.point({0, 0, 0}),
         color(node, "intensity", kWhite),
         {Falloff::kAngle, axis, std::cos(float(inner) * kDegree), std::cos(float(outer) * kDegree)}});
}

void MitsubaReader::emitter(Node node) {
    const std::string type = type_of(node);
    if (type == "point") {
        PointLight light;
        light.position = vector(node, "position").value_or(transform(node).point({0, 0, 0}));
        light.intensity = color(node, "intensity", kWhite);
        if (property(node, "power")) light.intensity = color(node, "power", kWhite) / (4 * kPi);
        loading_.scene.point_lights.push_back(light);
    } else if (type == "spot") {
        spot(node);
    } else if (type == "directional") {
        const Vec3 travels = vector(node, "direction").value_or(transform(node).vector({0, 0, 1}));
        if (length2(travels) == 0) fail_at(node, "the direction must not be zero");
        loading_.scene.directional_lights.push_back({-normalize(travels), color(node, "irradiance", kWhite)});
    } else if (type == "constant") {
        Environment env;
        env.scale = color(node, "radiance", kWhite);
        loading_.set_environment(env, where(node));
    } else if (type == "sunsky" || type == "sky" || type == "sun") {
        sky(node, type);
    } else if (type == "envmap") {
        envmap(node);
    } else {
        warn_at(node, "emitter '" + type + "' is not modelled; skipped");
    }
}

namespace {

/// Horizontal angle of view for a diagonal angle of view.
float across_width(float diagonal, float aspect) {
    const float d = 2 * std::tan(diagonal / 2);
    return 2 * std::atan(d / std::sqrt(1 + 1 / (aspect * aspect)) / 2);
}

}  // namespace

void MitsubaReader::sensor(Node node) {
    const std::string type = type_of(node);
    if (type != "perspective" && type != "thinlens")
        return warn_at(node, "sensor '" + type + "' is not modelled; skipped");
    if (type == "thinlens") warn_at(node, "'thinlens' is not modelled; a pinhole is used");
    Camera camera;
    camera.width = 768;
    camera.height = 576;
    if (const std::string id = attribute(node, "id"); !id.empty()) camera.name = id;
    for (const Node film : node.children("film")) {
        camera.width = integer(film, "width", camera.width);
        camera.height = integer(film, "height", camera.height);
        if (property(film, "crop_width") || property(film, "crop_height"))
            warn_at(film, "a crop is not modelled; the whole film is used");
    }
    if (camera.width < 1 || camera.height < 1) fail_at(node, "the film's width and height must be >= 1");

    // Mitsuba's camera looks along +z with x to the left.
    const Affine t = transform(node);
    camera.origin = t.point({0, 0, 0});
    camera.forward = normalize(t.vector({0, 0, 1}));
    const Vec3 up = t.vector({0, 1, 0}), right = -t.vector({1, 0, 0});
    camera.up = normalize(up - camera.forward * dot(up, camera.forward));
    const Vec3 side = normalize(cross(camera.forward, camera.up));
    camera.right = dot(side, right) < 0 ? -side : side;
    if (length2(camera.up) == 0 || t.determinant() == 0) fail_at(node, "the camera's transform is singular");

    // Convert the field of view from the axis that the file names.
    const float aspect = float(camera.width) / float(camera.height);
    std::string axis = string(node, "fov_axis", "x");
    float fov = float(number(node, "fov", 45)) * kDegree;
    if (const Node focal = property(node, "focal_length"); focal && !property(node, "fov")) {
        std::string text = attribute(focal, "value");
        if (text.size() > 2 && text.ends_with("mm")) text.resize(text.size() - 2);
        const auto mm = numbers(focal, text);
        if (mm.size() != 1 || !(mm[0] > 0)) fail_at(focal, "the focal length must be > 0");
        fov = 2 * std::atan(std::sqrt(36.f * 36.f + 24.f * 24.f) / (2 * float(mm[0])));
        axis = "diagonal";
    }
    if (!(fov > 0 && fov < kPi)) fail_at(node, "the field of view must be in (0, 180) degrees");
    if (axis != "x" && axis != "y" && axis != "smaller" && axis != "larger" && axis != "diagonal")
        fail_at(node, "unknown fov_axis '" + axis + "'");
    camera.fov_is_horizontal =
        axis != "y" && !(axis == "smaller" && aspect > 1) && !(axis == "larger" && aspect <= 1);
    camera.fov_y_rad = axis == "diagonal" ? across_width(fov, aspect) : fov;
    loading_.scene.cameras.push_back(camera);
}

}  // namespace viscache::loading
