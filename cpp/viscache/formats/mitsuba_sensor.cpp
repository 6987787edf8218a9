// Mitsuba XML: cameras.
#include "viscache/formats/clip_planes.h"
#include "viscache/formats/mitsuba_reader.h"

namespace viscache::loading {

namespace {

/// Horizontal angle of view for a diagonal angle of view.
float across_width(float diagonal, float aspect) {
    const float d = 2 * std::tan(diagonal / 2);
    return 2 * std::atan(d / std::sqrt(1 + 1 / (aspect * aspect)) / 2);
}

}  // namespace

/// Converts the field of view from the axis that the file names.
void MitsubaReader::field_of_view(Node node, Camera& camera) {
    const float aspect = float(camera.width) / float(camera.height);
    std::string axis = string(node, "fov_axis", "x");
    float fov = float(number(node, "fov", 45)) * float(kDegree);
    if (!property(node, "fov")) {
        float millimetres = 50;
        if (const Node focal = property(node, "focal_length")) {
            std::string text = attribute(focal, "value");
            if (text.size() > 2 && text.ends_with("mm")) text.resize(text.size() - 2);
            const auto mm = numbers(focal, text);
            if (mm.size() != 1 || !(mm[0] > 0)) fail_at(focal, "the focal length must be > 0");
            millimetres = float(mm[0]);
        }
        fov = 2 * std::atan(std::sqrt(36.f * 36.f + 24.f * 24.f) / (2 * millimetres));
        axis = "diagonal";
    }
    if (!(fov > 0 && fov < kPi)) fail_at(node, "the field of view must be in (0, 180) degrees");
    if (axis != "x" && axis != "y" && axis != "smaller" && axis != "larger" && axis != "diagonal")
        fail_at(node, "unknown fov_axis '" + axis + "'");
    camera.fov_is_horizontal =
        axis != "y" && !(axis == "smaller" && aspect > 1) && !(axis == "larger" && aspect <= 1);
    camera.fov_y_rad = axis == "diagonal" ? across_width(fov, aspect) : fov;
}

/// The film of an orthographic camera spans [-1, 1] of the transform's x axis.
void MitsubaReader::view_extent(Node node, Camera& camera) {
    const Affine t = transform(node);
    const float across = length(t.vector({1, 0, 0})), upwards = length(t.vector({0, 1, 0}));
    camera.fov_is_horizontal = true;
    camera.view_height = 2 * across;
    if (std::abs(across - upwards) > 1e-3f * across)
        warn_at(node, "pixels that are not square are not modelled; the width is kept");
}

void MitsubaReader::sensor(Node node) {
    const std::string type = type_of(node);
    use(node);
    if (type != "perspective" && type != "thinlens" && type != "orthographic")
        return skip(node, "sensor '" + type + "' is not modelled; skipped");
    if (type == "thinlens") warn_at(node, "'thinlens' is not modelled; a pinhole is used");
    Camera camera;
    camera.width = 768;
    camera.height = 576;
    if (const std::string id = attribute(node, "id"); !id.empty()) camera.name = id;
    for (const Node film : node.children("film")) {
        use(film);
        camera.width = integer(film, "width", camera.width);
        camera.height = integer(film, "height", camera.height);
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

    if (type == "orthographic")
        view_extent(node, camera);
    else
        field_of_view(node, camera);
    camera.shift_x = float(number(node, "principal_point_offset_x", 0));
    camera.shift_y = float(-number(node, "principal_point_offset_y", 0));
    for (const Node film : node.children("film")) crop(film, camera);
    clip_planes_.push_back({node, loading_.scene.cameras.size()});
    loading_.scene.cameras.push_back(camera);
}

/// The picture becomes a part of the film.
void MitsubaReader::crop(Node film, Camera& camera) {
    const int width = integer(film, "crop_width", camera.width),
              height = integer(film, "crop_height", camera.height), left = integer(film, "crop_offset_x", 0),
              top = integer(film, "crop_offset_y", 0);
    if (width == camera.width && height == camera.height && left == 0 && top == 0) return;
    if (left < 0 || top < 0 || width < 1 || height < 1 || left > camera.width - width ||
        top > camera.height - height)
        fail_at(film, "the crop must lie on the film");
    crop_camera(camera, left, top, width, height);
}

/// Near and far planes cut a picture in Mitsuba. They are not modelled, which matters where they cut
/// something.
void MitsubaReader::check_clip_planes() {
    for (const Clipped& clipped : clip_planes_) {
        const Node node = clipped.sensor;
        const ClipPlanes planes{float(number(node, "near_clip", 1e-2)), float(number(node, "far_clip", 1e4))};
        const CutGeometry cut = cut_geometry(loading_.scene, loading_.scene.cameras[clipped.camera], planes);
        const auto warn_of = [&](const char* name, const char* what) {
            const Node given = property(node, name);
            warn_at(given ? given : node, what);
        };
        if (cut.before) warn_of("near_clip", "the near plane is not modelled; what lies before it is seen");
        if (cut.behind) warn_of("far_clip", "the far plane is not modelled; what lies behind it is seen");
    }
}

}  // namespace viscache::loading
