//! The scene of the tests of commands and farms: a small room with a light, a glossy floor and a ball.

/// The scene as text: `settings` stand at its top, `sensor` within its sensor; the ball has a BSDF of type `ball`.
macro_rules! room {
    (settings: $settings:literal, sensor: $sensor:literal, width: $width:literal, height: $height:literal, ball: $ball:literal) => {
        concat!(
            r#"<scene version="3.0.0">
    "#,
            $settings,
            r#"
    <sensor type="perspective">
        <float name="fov" value="45"/>
        <transform name="to_world"><lookat origin="0, 1.5, 5" target="0, 0.8, 0" up="0, 1, 0"/></transform>
        "#,
            $sensor,
            r#"
        <film type="hdrfilm"><integer name="width" value=""#,
            $width,
            r#""/><integer name="height" value=""#,
            $height,
            r#""/></film>
    </sensor>
    <shape type="rectangle">
        <transform name="to_world"><scale value="4"/><rotate x="1" angle="-90"/></transform>
        <bsdf type="roughplastic"><rgb name="diffuse_reflectance" value="0.4, 0.3, 0.2"/></bsdf>
    </shape>
    <shape type="sphere">
        <point name="center" x="0" y="0.8" z="0"/><float name="radius" value="0.7"/>
        <bsdf type=""#,
            $ball,
            r#""/>
    </shape>
    <shape type="rectangle">
        <transform name="to_world"><rotate x="1" angle="90"/><translate y="3"/></transform>
        <emitter type="area"><rgb name="radiance" value="9, 8, 7"/></emitter>
    </shape>
</scene>
"#
        )
    };
}
pub(crate) use room;
