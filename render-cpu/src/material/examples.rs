//! The gallery: an example of every material, as the XML of its BSDF.

/// A material under the name of its plugin, or of what is special about it.
#[derive(Clone, Copy, Debug)]
pub struct Example {
    /// The name.
    pub name: &'static str,
    /// The BSDF.
    pub bsdf: &'static str,
}

/// All examples, in the order of the contact sheet.
pub const EXAMPLES: &[Example] = &[
    Example {
        name: "diffuse",
        bsdf: r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.5, 0.22, 0.12"/></bsdf>"#,
    },
    Example {
        name: "roughdiffuse",
        bsdf: r#"<bsdf type="roughdiffuse"><float name="alpha" value="0.7"/><rgb name="reflectance" value="0.5, 0.22, 0.12"/></bsdf>"#,
    },
    Example {
        name: "conductor",
        bsdf: r#"<bsdf type="conductor"><string name="material" value="Cu"/></bsdf>"#,
    },
    Example {
        name: "roughconductor",
        bsdf: r#"<bsdf type="roughconductor"><string name="material" value="Au"/><string name="distribution" value="ggx"/><float name="alpha" value="0.2"/></bsdf>"#,
    },
    Example {
        name: "roughconductor beckmann",
        bsdf: r#"<bsdf type="roughconductor"><string name="material" value="Al"/><string name="distribution" value="beckmann"/><float name="alpha" value="0.3"/></bsdf>"#,
    },
    Example {
        name: "roughconductor phong",
        bsdf: r#"<bsdf type="roughconductor"><string name="material" value="Ag"/><string name="distribution" value="phong"/><float name="alpha" value="0.15"/></bsdf>"#,
    },
    Example {
        name: "roughconductor anisotropic",
        bsdf: r#"<bsdf type="roughconductor"><string name="material" value="Al"/><string name="distribution" value="ggx"/><float name="alpha_u" value="0.05"/><float name="alpha_v" value="0.4"/></bsdf>"#,
    },
    Example {
        name: "roughconductor epd",
        bsdf: r#"<bsdf type="roughconductor"><string name="material" value="Cu"/><string name="distribution" value="epd"/><float name="alpha" value="0.1"/><float name="exponent" value="0.4"/></bsdf>"#,
    },
    Example {
        name: "roughconductor textured",
        bsdf: r#"<bsdf type="roughconductor"><string name="material" value="Au"/><string name="distribution" value="ggx"/><texture name="alpha" type="checkerboard"><rgb name="color0" value="0.05"/><rgb name="color1" value="0.4"/><transform name="to_uv"><scale value="6"/></transform></texture></bsdf>"#,
    },
    Example {
        name: "ctd",
        bsdf: r#"<bsdf type="ctd"><string name="material" value="Au"/></bsdf>"#,
    },
    Example {
        name: "merl",
        bsdf: r#"<bsdf type="merl"><string name="filename" value="$halflight_folder/nickel.binary"/></bsdf>"#,
    },
    Example {
        name: "measured",
        bsdf: r#"<bsdf type="measured"><string name="filename" value="$halflight_folder/brushed.bsdf"/></bsdf>"#,
    },
    Example {
        name: "principledthin",
        bsdf: r#"<bsdf type="principledthin"><rgb name="base_color" value="0.6, 0.7, 0.3"/><float name="roughness" value="0.4"/><float name="spec_trans" value="0.4"/><float name="diff_trans" value="1"/></bsdf>"#,
    },
    Example {
        name: "hk",
        bsdf: r#"<bsdf type="hk"><rgb name="sigma_s" value="1.2, 0.8, 0.4"/><rgb name="sigma_a" value="0.02, 0.05, 0.1"/><float name="thickness" value="1.5"/></bsdf>"#,
    },
    Example {
        name: "dielectric",
        bsdf: r#"<bsdf type="dielectric"/>"#,
    },
    Example {
        name: "thindielectric",
        bsdf: r#"<bsdf type="thindielectric"/>"#,
    },
    Example {
        name: "roughdielectric",
        bsdf: r#"<bsdf type="roughdielectric"><string name="distribution" value="ggx"/><float name="alpha" value="0.2"/></bsdf>"#,
    },
    Example {
        name: "plastic",
        bsdf: r#"<bsdf type="plastic"><rgb name="diffuse_reflectance" value="0.1, 0.27, 0.36"/><boolean name="nonlinear" value="true"/></bsdf>"#,
    },
    Example {
        name: "plastic absorbing",
        bsdf: r#"<bsdf type="plastic"><rgb name="diffuse_reflectance" value="0.95"/><rgb name="sigma_a" value="0.05, 0.3, 1.2"/><boolean name="nonlinear" value="true"/></bsdf>"#,
    },
    Example {
        name: "roughplastic",
        bsdf: r#"<bsdf type="roughplastic"><rgb name="diffuse_reflectance" value="0.1, 0.27, 0.36"/><float name="alpha" value="0.2"/><boolean name="nonlinear" value="true"/></bsdf>"#,
    },
    Example {
        name: "roughplastic textured",
        bsdf: r#"<bsdf type="roughplastic"><rgb name="diffuse_reflectance" value="0.4, 0.05, 0.04"/><texture name="alpha" type="checkerboard"><rgb name="color0" value="0.04"/><rgb name="color1" value="0.45"/><transform name="to_uv"><scale value="8"/></transform></texture></bsdf>"#,
    },
    Example {
        name: "roughplastic absorbing",
        bsdf: r#"<bsdf type="roughplastic"><rgb name="diffuse_reflectance" value="0.95"/><rgb name="sigma_a" value="0.05, 0.3, 1.2"/><float name="alpha" value="0.2"/><boolean name="nonlinear" value="true"/></bsdf>"#,
    },
    Example {
        name: "coating",
        bsdf: r#"<bsdf type="coating"><bsdf type="roughconductor"><string name="material" value="Cu"/><string name="distribution" value="ggx"/><float name="alpha" value="0.3"/></bsdf></bsdf>"#,
    },
    Example {
        name: "coating absorbing",
        bsdf: r#"<bsdf type="coating"><rgb name="sigma_a" value="1.2, 0.4, 0.05"/><bsdf type="roughconductor"><string name="material" value="Ag"/><string name="distribution" value="ggx"/><float name="alpha" value="0.3"/></bsdf></bsdf>"#,
    },
    Example {
        name: "roughcoating",
        bsdf: r#"<bsdf type="roughcoating"><float name="alpha" value="0.2"/><rgb name="sigma_a" value="0.05, 0.5, 0.9"/><bsdf type="roughconductor"><string name="material" value="Ag"/><string name="distribution" value="ggx"/><float name="alpha" value="0.1"/></bsdf></bsdf>"#,
    },
    Example {
        name: "roughcoating textured",
        bsdf: r#"<bsdf type="roughcoating"><texture name="alpha" type="checkerboard"><rgb name="color0" value="0.03"/><rgb name="color1" value="0.4"/><transform name="to_uv"><scale value="6"/></transform></texture><bsdf type="diffuse"><rgb name="reflectance" value="0.02, 0.1, 0.15"/></bsdf></bsdf>"#,
    },
    Example {
        name: "coating twice",
        bsdf: r#"<bsdf type="coating"><float name="int_ior" value="1.3"/><bsdf type="coating"><float name="int_ior" value="1.7"/><float name="ext_ior" value="1.3"/><rgb name="sigma_a" value="0.1, 0.6, 0.1"/><bsdf type="diffuse"><rgb name="reflectance" value="0.9"/></bsdf></bsdf></bsdf>"#,
    },
    Example {
        name: "blendbsdf",
        bsdf: r#"<bsdf type="blendbsdf"><texture name="weight" type="checkerboard"><rgb name="color0" value="0"/><rgb name="color1" value="1"/><transform name="to_uv"><scale value="6"/></transform></texture><bsdf type="plastic"><rgb name="diffuse_reflectance" value="0.9"/></bsdf><bsdf type="roughconductor"><string name="material" value="Au"/></bsdf></bsdf>"#,
    },
    Example {
        name: "mixturebsdf",
        bsdf: r#"<bsdf type="mixturebsdf"><string name="weights" value="0.4, 0.3, 0.3"/><bsdf type="diffuse"><rgb name="reflectance" value="0.05, 0.2, 0.1"/></bsdf><bsdf type="roughconductor"><string name="material" value="Al"/><float name="alpha" value="0.3"/></bsdf><bsdf type="conductor"><string name="material" value="Al"/></bsdf></bsdf>"#,
    },
    Example {
        name: "mask",
        bsdf: r#"<bsdf type="mask"><texture name="opacity" type="checkerboard"><rgb name="color0" value="0"/><rgb name="color1" value="1"/><transform name="to_uv"><scale value="10"/></transform></texture><bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.3, 0.35, 0.6"/></bsdf></bsdf></bsdf>"#,
    },
];
