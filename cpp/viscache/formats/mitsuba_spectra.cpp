// Mitsuba XML: spectra, converted as Mitsuba 3 does in its RGB variants.
#include "viscache/formats/mitsuba_reader.h"

namespace viscache::loading {

/// What the spectrum of an element describes: the value of a light is not relative to a white.
SpectrumOf MitsubaReader::spectrum_use(Node node) const {
    for (; node; node = node.parent()) {
        const std::string_view tag = node.name();
        if (tag == "emitter" || tag == "luminaire") return SpectrumOf::kLight;
    }
    return SpectrumOf::kReflectance;
}

Rgb MitsubaReader::converted(const Spectrum& spectrum, Node node) const {
    return max({0, 0, 0}, spectrum_to_rgb(spectrum, spectrum_use(node)));
}

Rgb MitsubaReader::spectrum_pairs(const std::vector<double>& v, Node node) const {
    if (v.size() < 2 || v.size() % 2) fail_at(node, "a spectrum must be a list of nm:value");
    Spectrum spectrum;
    for (size_t i = 0; i < v.size(); i += 2) {
        if (!spectrum.empty() && v[i] <= spectrum.back().first)
            fail_at(node, "the wavelengths of a spectrum must grow");
        spectrum.emplace_back(v[i], v[i + 1]);
    }
    return converted(spectrum, node);
}

/// The content of a file of pairs without its comments.
std::string MitsubaReader::spectrum_file(Node node) const {
    std::string text = read_file(find_file(attribute(node, "filename"), node), where(node));
    for (size_t i = 0; (i = text.find('#', i)) != std::string::npos;)
        text.erase(i, std::min(text.find('\n', i), text.size()) - i);
    return text;
}

/// <spectrum> with pairs, a file, or one value for all wavelengths.
Rgb MitsubaReader::spectrum_value(Node node) const {
    if (node.attribute("filename")) return spectrum_pairs(numbers(node, spectrum_file(node)), node);
    std::string text = attribute(node, "value");
    if (text.find(':') != std::string::npos) {
        std::replace(text.begin(), text.end(), ':', ' ');
        return spectrum_pairs(numbers(node, text), node);
    }
    const Rgb value = rgb_value(node);
    const bool uniform = parse_number(text).has_value();
    return uniform && spectrum_use(node) == SpectrumOf::kLight ? equal_energy_rgb(value.x) : value;
}

/// The spectrum plugins `regular` and `irregular`.
Rgb MitsubaReader::spectrum_samples(Node node, bool regular) {
    const auto list = [&](const char* name) {
        const Node given = property(node, name);
        if (!given) fail_at(node, std::string("this spectrum needs '") + name + "'");
        return numbers(given, attribute(given, "value"));
    };
    const auto values = list("values");
    std::vector<double> nm;
    if (!regular) nm = list("wavelengths");
    const double first = number(node, "wavelength_min", 360), last = number(node, "wavelength_max", 830);
    for (size_t i = 0; regular && i < values.size(); ++i)
        nm.push_back(first + (last - first) * double(i) / double(std::max<size_t>(values.size() - 1, 1)));
    if (nm.size() != values.size()) fail_at(node, "a spectrum must have as many values as wavelengths");
    std::vector<double> pairs;
    for (size_t i = 0; i < nm.size(); ++i) pairs.insert(pairs.end(), {nm[i], values[i]});
    return spectrum_pairs(pairs, node);
}

Rgb MitsubaReader::blackbody(Node node, bool plugin) {
    const double kelvin =
        plugin ? number(node, "temperature", 5000) : attribute_number(node, "temperature", 5000);
    if (!(kelvin > 0)) fail_at(node, "the temperature must be > 0");
    const double scale = plugin ? number(node, "scale", 1) : attribute_number(node, "scale", 1);
    return max({0, 0, 0}, blackbody_rgb(kelvin) * float(scale));
}

/// A spectrum plugin; empty if the type is none.
std::optional<Rgb> MitsubaReader::spectrum_plugin(Node node, const std::string& type) {
    if (type == "blackbody") return blackbody(node, true);
    if (type == "regular" || type == "irregular") return spectrum_samples(node, type == "regular");
    // Daylight is white, scaled by a number or a colour
    if (type == "d65") return color(node, "color", {1, 1, 1}) * float(number(node, "scale", 1));
    if (type == "uniform") return color(node, "value", {1, 1, 1});
    if (type == "rgb" || type == "srgb") return color(node, "color", {.5f, .5f, .5f});
    return {};
}

}  // namespace viscache::loading
