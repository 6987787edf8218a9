// Mitsuba XML: attributes, properties, transforms, colours and textures.
#include "viscache/formats/mitsuba_reader.h"

namespace viscache::loading {

namespace {

bool is_name_char(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

}  // namespace

bool same_name(const char* given, std::string_view snake) {
    size_t at = 0;
    const auto next_is = [&](char c) { return at < snake.size() && snake[at++] == c; };
    bool was_lower = false;
    for (const char* c = given; *c; ++c) {
        const bool upper = *c >= 'A' && *c <= 'Z';
        if (upper && was_lower && !next_is('_')) return false;
        if (!next_is(upper ? char(*c - 'A' + 'a') : *c)) return false;
        was_lower = !upper && *c != '_';
    }
    return at == snake.size();
}

std::string MitsubaReader::attribute(Node node, const char* name) const {
    std::string_view text = node.attribute(name).value();
    std::string out;
    while (!text.empty()) {
        const size_t dollar = std::min(text.find('$'), text.size());
        out += text.substr(0, dollar);
        text.remove_prefix(dollar);
        if (text.empty()) break;
        size_t end = 1;
        while (end < text.size() && is_name_char(text[end])) ++end;
        const auto found = parameters_.find(std::string(text.substr(1, end - 1)));
        // Mitsuba sets parameters from its command line. There is none here, so a default must exist.
        if (found == parameters_.end())
            fail_at(node, "the parameter '" + std::string(text.substr(0, end)) + "' has no default");
        out += found->second;
        text.remove_prefix(end);
    }
    return out;
}

MitsubaReader::Node MitsubaReader::property(Node owner, const char* name) const {
    for (const Node child : owner.children())
        // The 0.x dialect writes names in camelCase, later versions in snake_case.
        if (same_name(child.attribute("name").value(), name)) {
            use(child);
            return child;
        }
    return {};
}

std::vector<double> MitsubaReader::numbers(Node node, const std::string& text) const {
    std::vector<double> out;
    const char* const separators = " ,\t\r\n";
    for (size_t i = text.find_first_not_of(separators); i != std::string::npos;) {
        const size_t end = std::min(text.find_first_of(separators, i), text.size());
        const auto x = parse_number(std::string_view(text).substr(i, end - i));
        if (!x || !std::isfinite(*x))
            fail_at(node, "a finite number must stand here, got '" +
                              text.substr(i, std::min<size_t>(end - i, 40)) + "'");
        out.push_back(*x);
        i = text.find_first_not_of(separators, end);
    }
    return out;
}

double MitsubaReader::attribute_number(Node node, const char* name, double fallback) const {
    if (!node.attribute(name)) return fallback;
    const auto values = numbers(node, attribute(node, name));
    if (values.size() != 1) fail_at(node, std::string("'") + name + "' must be one number");
    return values[0];
}

double MitsubaReader::number(Node owner, const char* name, double fallback) {
    const Node node = property(owner, name);
    if (!node) return fallback;
    if (node.attribute("value")) {
        const auto values = numbers(node, attribute(node, "value"));
        if (values.empty()) fail_at(node, std::string("'") + name + "' must be a number");
        if (values.size() == 1) return values[0];
    }
    warn_at(node, std::string("'") + name + "' is not one number; " + std::to_string(fallback) + " is used");
    return fallback;
}

int MitsubaReader::integer(Node owner, const char* name, int fallback) {
    const double x = number(owner, name, fallback);
    if (x != std::floor(x) || std::abs(x) > 2e9)
        fail_at(property(owner, name), std::string("'") + name + "' must be an integer");
    return int(x);
}

bool MitsubaReader::boolean(Node owner, const char* name, bool fallback) {
    const Node node = property(owner, name);
    if (!node) return fallback;
    const std::string value = lower(attribute(node, "value"));
    if (value != "true" && value != "false")
        fail_at(node, std::string("'") + name + "' must be true or false, got '" + value + "'");
    return value == "true";
}

std::string MitsubaReader::string(Node owner, const char* name, const std::string& fallback) {
    const Node node = property(owner, name);
    return node ? attribute(node, "value") : fallback;
}

std::optional<Vec3> MitsubaReader::vector(Node owner, const char* name) {
    const Node node = property(owner, name);
    if (!node) return {};
    if (node.attribute("value")) {
        const auto v = numbers(node, attribute(node, "value"));
        if (v.size() != 3) fail_at(node, std::string("'") + name + "' must be three numbers");
        return Vec3{float(v[0]), float(v[1]), float(v[2])};
    }
    return Vec3{float(attribute_number(node, "x", 0)), float(attribute_number(node, "y", 0)),
                float(attribute_number(node, "z", 0))};
}

Affine MitsubaReader::look_at_matrix(Node step) {
    Vec3 v[3] = {{0, 0, 0}, {0, 0, 1}, {0, 1, 0}};
    const char* const names[3] = {"origin", "target", "up"};
    for (int i = 0; i < 3; ++i) {
        if (!step.attribute(names[i])) continue;
        const auto x = numbers(step, attribute(step, names[i]));
        if (x.size() != 3) fail_at(step, std::string("'") + names[i] + "' must be three numbers");
        v[i] = {float(x[0]), float(x[1]), float(x[2])};
    }
    // The frame needs a direction of view.
    if (v[0] == v[1]) fail_at(step, "lookat needs a target other than its origin");
    // Columns are left, up, forward, origin: the frame of `look_at` with x to the left.
    const Camera camera = look_at(v[0], v[1], v[2], 1.f);
    const Vec3 columns[4] = {-camera.right, camera.up, camera.forward, camera.origin};
    Affine t;
    for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 3; ++i) t.m[i][j] = columns[j][i];
    return t;
}

Affine MitsubaReader::transform_step(Node step) {
    const std::string tag = lower(step.name());
    if (tag == "lookat") return look_at_matrix(step);
    const auto value = numbers(step, attribute(step, "value"));
    if (tag == "matrix") {
        if (value.size() != 16 && value.size() != 9) fail_at(step, "a matrix must have 16 or 9 numbers");
        Affine t;
        const size_t n = value.size() == 16 ? 4 : 3;
        for (size_t i = 0; i < 3; ++i)
            for (size_t j = 0; j < n; ++j) t.m[i][j] = value[i * n + j];
        // Projective maps have no place in an affine transform.
        if (n == 4 && (value[12] != 0 || value[13] != 0 || value[14] != 0 || value[15] != 1))
            fail_at(step, "the last row of a matrix must be 0 0 0 1");
        return t;
    }
    // A component that is not given leaves its axis as it is.
    const double missing = tag == "scale" ? 1 : 0;
    double v[3] = {attribute_number(step, "x", missing), attribute_number(step, "y", missing),
                   attribute_number(step, "z", missing)};
    if (value.size() == 1) v[0] = v[1] = v[2] = value[0];
    if (value.size() == 3) std::copy(value.begin(), value.end(), v);
    if (value.size() != 0 && value.size() != 1 && value.size() != 3)
        fail_at(step, "one or three numbers are needed");
    if (tag == "translate") return translation(v[0], v[1], v[2]);
    if (tag == "scale") return scaling(v[0], v[1], v[2]);
    if (tag == "rotate") {
        const bool old = version_major_ < 2;
        const Warning warning{where(step),
                              "the axis of a rotation is no unit vector: Mitsuba 3 scales by its length, "
                              "but round shapes and normals by its inverse"};
        const double length2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        // Some transforms are read more than once
        const auto same = [&](const Warning& w) {
            return w.where == warning.where && w.text == warning.text;
        };
        if (!old && std::abs(length2 - 1) > 1e-3 && std::ranges::none_of(loading_.scene.warnings, same))
            warn_at(step, warning.text);
        return rotation(attribute_number(step, "angle", 0), v[0], v[1], v[2], old);
    }
    fail_at(step, "unknown transform <" + std::string(step.name()) + ">");
}

Affine MitsubaReader::transform(Node owner, const char* name) {
    Affine t;
    if (const Node node = property(owner, name))
        for (const Node step : node.children())
            // Steps apply in the order of the file: the first is nearest to the point.
            if (step.type() == pugi::node_element) t = transform_step(step) * t;
    if (!is_finite(t)) fail_at(owner, "the transform is not finite");
    return t;
}

Rgb MitsubaReader::rgb_value(Node node) const {
    const std::string text = attribute(node, "value");
    const bool encoded = std::string_view(node.name()) == "srgb";
    if (!text.empty() && text[0] == '#') {
        // Hexadecimal colours are sRGB, as in HTML, while plain numbers are linear.
        if (text.size() != 7 || text.find_first_not_of("0123456789abcdefABCDEF", 1) != std::string::npos)
            fail_at(node, "a colour must be #rrggbb, got '" + text.substr(0, 20) + "'");
        const unsigned long hex = std::stoul(text.substr(1), nullptr, 16);
        return {srgb_to_linear(float(hex >> 16 & 255) / 255.f), srgb_to_linear(float(hex >> 8 & 255) / 255.f),
                srgb_to_linear(float(hex & 255) / 255.f)};
    }
    auto v = numbers(node, text);
    if (v.size() == 1) v = {v[0], v[0], v[0]};
    if (v.size() != 3)
        fail_at(node, "a colour must be one or three numbers, got " + std::to_string(v.size()));
    Rgb c{float(v[0]), float(v[1]), float(v[2])};
    if (encoded) c = {srgb_to_linear(c.x), srgb_to_linear(c.y), srgb_to_linear(c.z)};
    return c;
}

ColorTexture MitsubaReader::texture(Node node, int depth) {
    if (depth > kMaxDepth) fail_at(node, "references to textures are cyclic");
    const std::string_view tag = node.name();
    use(node);
    // A texture may be any element that has a colour: numbers, spectra, images, or a reference to one.
    if (tag == "ref") return texture(target_of(node), depth + 1);
    if (tag == "rgb" || tag == "srgb" || tag == "float" || tag == "integer" || tag == "color")
        return {rgb_value(node)};
    const std::string type = node.attribute("type") ? type_of(node) : "";
    if (tag == "blackbody") return {blackbody(node, false)};
    if (tag == "spectrum" && (type.empty() || node.attribute("value"))) return {spectrum_value(node)};
    if (const auto value = spectrum_plugin(node, type)) return {*value};
    if (type == "bitmap") return bitmap(node);
    if (type == "checkerboard") return checkerboard(node);
    if (type == "mesh_attribute") {
        const float scale = float(number(node, "scale", 1));
        return {{scale, scale, scale}, -1, string(node, "name", "")};
    }
    if (type == "scale") {
        for (const Node child : node.children())
            if (std::string_view(child.name()) == "texture" || std::string_view(child.name()) == "ref") {
                ColorTexture t = texture(child, depth + 1);
                t.color = t.color * color(node, "scale", {1, 1, 1});
                return t;
            }
    }
    skip(node, "texture '" + (type.empty() ? std::string(tag) : type) + "' is not modelled; grey is used");
    return {{.5f, .5f, .5f}};
}

ColorTexture MitsubaReader::bitmap(Node node) {
    // `raw` in Mitsuba 3 and a gamma of 1 in 0.x both mean linear values.
    const bool is_linear = number(node, "gamma", 0) == 1.0, raw = boolean(node, "raw", is_linear);
    const std::string name = string(node, "wrap_mode", "repeat");
    const auto wrap = wrap_named(name);
    if (!wrap) warn_at(node, "wrap mode '" + name + "' is not modelled; the image repeats");
    const Wrap both = wrap.value_or(Wrap::kRepeat);
    const bool nearest = string(node, "filter_type", "") == "nearest";
    note_uv(node);
    return {{1, 1, 1}, loading_.add_image(path_of(node), where(node), !raw, {nearest, both, both})};
}

ColorTexture MitsubaReader::checkerboard(Node node) {
    note_uv(node);
    const Rgb first = color(node, "color0", {.4f, .4f, .4f}), second = color(node, "color1", {.2f, .2f, .2f});
    // The square at (0, 0) of the file lies at the top here: v = 1
    return {{1, 1, 1}, loading_.add_checkerboard(second, first, where(node))};
}

/// Notes `to_uv`, or the scale and offset of older files. v grows downwards there.
void MitsubaReader::note_uv(Node node) {
    if (!uv_) return;
    Affine t = transform(node, "to_uv");
    if (!property(node, "to_uv")) {
        const double scale = number(node, "uvscale", 1);
        t = scaling(number(node, "uscale", scale), number(node, "vscale", scale), 1);
        t.m[0][3] = number(node, "uoffset", 0);
        t.m[1][3] = number(node, "voffset", 0);
    }
    const auto& m = t.m;
    const UvTransform given{{{m[0][0], m[0][1], m[0][3]}, {m[1][0], m[1][1], m[1][3]}}};
    if (!uv_->add(given.downwards()))
        warn_at(node,
                "the images of a material share one transform of texture coordinates; that of the "
                "first is used");
}

ColorTexture MitsubaReader::color_texture(Node owner, const char* name, Rgb fallback, bool may_be_attribute) {
    const Node node = property(owner, name);
    ColorTexture t = node ? texture(node) : ColorTexture{fallback};
    if (!may_be_attribute && !t.attribute.empty()) {
        warn_at(node, "an attribute of meshes is modelled as a base colour alone; a default is used");
        t = {fallback};
    }
    return t;
}

Rgb MitsubaReader::color(Node owner, const char* name, Rgb fallback) {
    const ColorTexture t = color_texture(owner, name, fallback);
    if (t.image >= 0)
        warn_at(property(owner, name),
                std::string("an image for '") + name + "' is not modelled; white is used");
    return t.color;
}

}  // namespace viscache::loading
