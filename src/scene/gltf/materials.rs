//! Materials: what of them says whether a surface hides what is behind it (glTF §3.9).

use ::gltf::json::material::AlphaMode;
use ::gltf::json::validation::Checked;

use super::{Result, Source, label, lookup};
use crate::scene::error::Fault;
use crate::scene::{Alpha, Material};

/// The material a primitive names, or the default one.
pub(super) fn material(source: &Source, index: Option<u32>) -> Result<Material> {
    let Some(index) = index else {
        return Ok(Material::default());
    };
    let record = lookup(&source.document.materials, index, "material")?;
    let Checked::Valid(mode) = record.alpha_mode else {
        return Err(Fault::damaged(
            label("material", index, record.name.as_deref()),
            "its alphaMode is none of OPAQUE, MASK and BLEND",
        ));
    };
    let factor = record
        .pbr_metallic_roughness
        .as_ref()
        .and_then(|pbr| pbr.base_color_factor)
        .unwrap_or([1.0; 4]);
    // One sees through glass that transmits, whatever its alphaMode (KHR_materials_transmission).
    let transmits = record
        .extensions
        .as_ref()
        .and_then(|e| e.transmission.as_ref());
    let alpha = match mode {
        AlphaMode::Mask => Alpha::Mask,
        AlphaMode::Blend => Alpha::Blend,
        AlphaMode::Opaque if transmits.is_some_and(|t| t.transmission_factor > 0.0) => Alpha::Blend,
        AlphaMode::Opaque => Alpha::Opaque,
    };
    Ok(Material {
        alpha,
        double_sided: record.double_sided,
        color: factor.map(|c| c.clamp(0.0, 1.0)),
    })
}
