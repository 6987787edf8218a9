#pragma once
// The few materials that a study of visibility needs. Loaders map the materials of a file to the nearest of
// these.
#include "viscache/math/vec.h"
#include "viscache/scene/conductor.h"

namespace viscache {

enum class MaterialKind : uint8_t {
    kDiffuse,     ///< Lambertian: `base_color`
    kGlossy,      ///< Lambertian `base_color` plus a GGX lobe: `specular` (reflectance at 0°), `roughness`
    kMirror,      ///< perfect mirror: `specular`
    kDielectric,  ///< smooth glass: `eta`; reflects and refracts
};

/// The layer over the Lambertian part of a glossy material.
enum class CoatKind : uint8_t {
    kNone,        ///< none: the lobe has Schlick's Fresnel term of `specular`
    kSmooth,      ///< a smooth dielectric of index `eta`
    kRough,       ///< a rough dielectric of index `eta` and of `roughness`
    kBeckmann,    ///< the same with Beckmann's microfacets
    kFresnelMix,  ///< none, but what the lobe's Schlick term reflects at the half vector is what the base
                  ///< loses (glTF); of a thin dielectric: its reflectance is that term
};

struct Material {
    MaterialKind kind = MaterialKind::kDiffuse;
    Rgb base_color{0.5f, 0.5f, 0.5f};  ///< albedo of the Lambertian part, in [0, 1]
    Rgb specular{1, 1, 1};             ///< reflectance of the GGX or mirror part at normal incidence
    float roughness = 0.1f;            ///< alpha of the microfacets, in [1e-3, 1]
    float eta = 1.5f;                  ///< interior over exterior index of refraction; of glass and of coats
    bool two_sided = true;             ///< false: the back side is black
    int base_texture = -1;             ///< image that multiplies `base_color`; -1: none
    int alpha_texture = -1;            ///< image whose alpha (or value) cuts holes; -1: none
    float alpha_cutoff = 0.5f;         ///< absent where alpha is below; negative: alpha is a share
    CoatKind coat = CoatKind::kNone;  ///< of glossy materials; under a coat, `specular` scales its reflection
    bool nonlinear = false;  ///< under a coat, light scatters inside: colours get darker and stronger
    bool thin = false;  ///< a dielectric that is a plate without thickness, or a glossy sheet (kFresnelMix)
                        ///< that lets light straight through
    float opacity = 1;  ///< share of the surface that is there; the rest are small holes
    float metallic =
        0;  ///< of glossy materials: the share that is metal, whose `specular` is the base colour
    int metallic_roughness_texture = -1;  ///< image, as in glTF: green multiplies √roughness, blue `metallic`
    int roughness_texture = -1;           ///< image that multiplies `roughness`; -1: none
    Conductor metal{};      ///< of mirrors and of glossy materials without a base: the index of refraction;
                            ///< `specular` then scales the reflection
    bool beckmann = false;  ///< the lobe of a glossy material without a rough coat is Beckmann's, not GGX's
    float f90 = 1;          ///< of kFresnelMix: reflectance of the lobe at grazing incidence
    Rgb transmission{1, 1, 1};  ///< factor of what passes a dielectric or a glossy sheet, once per surface;
                                ///< `base_texture` multiplies it

    /// True if light passes it: through glass, or straight through a glossy sheet.
    bool transmits() const { return kind == MaterialKind::kDielectric || thin; }
    bool has_beckmann() const { return beckmann || coat == CoatKind::kBeckmann; }
    /// True if base colour, `specular` and `roughness` have to be found for each point.
    bool mixes_metal() const {
        return metallic > 0 || metallic_roughness_texture >= 0 || roughness_texture >= 0;
    }
};

}  // namespace viscache
