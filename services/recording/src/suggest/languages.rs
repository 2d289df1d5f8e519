//! Names of signals in other languages than English, word by word.

/// A word, or the beginning of one, and what it is in the words by which signals are found. Longer words stand before those that
/// they contain.
const WORDS: &[(&str, &str)] = &[
    // German.
    ("schwenk", "swing"),
    ("drehgeschwindigkeit", "swing vel"),
    ("drehwinkel", "swing angle"),
    ("oberwagen", "swing"),
    ("drehmoment", "torque"),
    ("winkelgeschwindigkeit", "vel"),
    ("fahrgeschwindigkeit", "vehicle speed"),
    ("geschwindigkeit", "speed"),
    ("drehzahl", "speed"),
    ("beschleunigung", "accel"),
    ("winkel", "angle"),
    ("ausleger", "boom"),
    ("hubarm", "lift arm"),
    ("stiel", "stick"),
    ("löffel", "bucket"),
    ("loeffel", "bucket"),
    ("schaufel", "bucket"),
    ("bodenseit", "head"),
    ("kolbenseit", "head"),
    ("stangenseit", "rod"),
    ("druck", "press"),
    ("vorderachs", "front axle"),
    ("hinterachs", "rear axle"),
    ("vorderrad", "front wheel"),
    ("hinterrad", "rear wheel"),
    ("vorn", "front"),
    ("hinten", "rear"),
    ("steigung", "slope"),
    ("längsneigung", "pitch"),
    ("querneigung", "roll"),
    ("neigung", "inclin"),
    ("masse", "mass"),
    ("bremse", "brake"),
    // French.
    ("tourelle", "swing"),
    ("orientation", "swing"),
    ("rotation", "swing"),
    ("couple", "torque"),
    ("vitesse", "speed"),
    ("accélération", "accel"),
    ("flèche", "boom"),
    ("fleche", "boom"),
    ("balancier", "arm"),
    ("godet", "bucket"),
    ("pression", "press"),
    ("fond de vérin", "head"),
    ("tige", "rod"),
    ("avant", "front"),
    ("arrière", "rear"),
    ("arriere", "rear"),
    ("pente", "slope"),
    ("temps", "time"),
    ("roue", "wheel"),
    ("frein", "brake"),
    // Spanish.
    ("giro", "swing"),
    ("par_", "torque_"),
    ("par ", "torque "),
    ("velocidad", "speed"),
    ("aceleración", "accel"),
    ("aceleracion", "accel"),
    ("ángulo", "angle"),
    ("angulo", "angle"),
    ("pluma", "boom"),
    ("brazo", "arm"),
    ("cucharón", "bucket"),
    ("cucharon", "bucket"),
    ("balde", "bucket"),
    ("cazo", "bucket"),
    ("presión", "press"),
    ("presion", "press"),
    ("vástago", "rod"),
    ("vastago", "rod"),
    ("delanter", "front"),
    ("traser", "rear"),
    ("pendiente", "slope"),
    ("tiempo", "time"),
    ("rueda", "wheel"),
    ("masa", "mass"),
    ("freno", "brake"),
    // Japanese.
    ("旋回", "swing"),
    ("ブーム", "boom"),
    ("アーム", "arm"),
    ("バケット", "bucket"),
    ("トルク", "torque"),
    ("角速度", "vel"),
    ("加速度", "accel"),
    ("車速", "vehicle speed"),
    ("速度", "speed"),
    ("角度", "angle"),
    ("ボトム", "head"),
    ("ヘッド", "head"),
    ("ロッド", "rod"),
    ("前輪", "front wheel"),
    ("後輪", "rear wheel"),
    ("勾配", "slope"),
    ("時刻", "time"),
    ("時間", "time"),
    ("質量", "mass"),
    // Chinese; what both write alike stands above.
    ("回转", "swing"),
    ("动臂", "boom"),
    ("斗杆", "arm"),
    ("铲斗", "bucket"),
    ("扭矩", "torque"),
    ("转矩", "torque"),
    ("车速", "vehicle speed"),
    ("压力", "press"),
    ("圧力", "press"),
    ("无杆腔", "head"),
    ("有杆腔", "rod"),
    ("前轮", "front wheel"),
    ("后轮", "rear wheel"),
    ("坡度", "slope"),
    ("时间", "time"),
    ("质量", "mass"),
    // Short for cylinder pressures, as on excavators' buses.
    ("btm", "head"),
    ("bottom", "head"),
    ("prs", "press"),
    // Short words of English.
    ("trq", "torque"),
    ("spd", "speed"),
    ("whl", "wheel"),
    ("bkt", "bucket"),
];

/// A name in small letters with its words in English.
pub(super) fn english(name: &str) -> String {
    let mut name = name.to_lowercase();
    for (word, meaning) in WORDS {
        if name.contains(word) {
            // Words of these languages stand close together; their meanings must not grow into others.
            name = name.replace(word, &format!(" {meaning} ").replace("_ ", "_"));
        }
    }
    name
}

#[cfg(test)]
mod tests {
    use super::super::names::fitting;

    #[test]
    fn signals_are_found_in_other_languages() {
        for (signal, name) in [
            ("swing_torque", "Schwenkmoment [kNm]"),
            ("swing_velocity", "Schwenkgeschwindigkeit [°/s]"),
            ("swing_velocity", "Drehgeschwindigkeit [°/s]"),
            ("boom_angle", "Auslegerwinkel"),
            ("arm_angle", "Stielwinkel [deg]"),
            ("bucket_angle", "Löffelwinkel"),
            ("swing_torque", "couple_tourelle"),
            ("boom_angle", "angle flèche"),
            ("arm_angle", "angle_balancier"),
            ("swing_velocity", "velocidad_giro"),
            ("swing_torque", "par_giro"),
            ("bucket_angle", "Ángulo cucharón"),
            ("swing_velocity", "旋回角速度"),
            ("boom_angle", "ブーム角度"),
            ("swing_torque", "回转扭矩"),
            ("bucket_angle", "铲斗角度"),
            ("front_wheel_speed", "前轮速度"),
            ("slope", "Steigung"),
            ("boom_head_pressure", "boom_btm_prs"),
            ("boom_head_pressure", "BoomCyl_CapEnd_Press"),
            ("arm_head_pressure", "StickCyl Bottom Prs"),
            ("lift_rod_pressure", "HoistCyl Rod Press"),
            ("swing_torque", "SwingTrq"),
            ("lift_angle", "LiftArmAng"),
            ("tilt_angle", "tilt_ang_deg"),
            ("front_wheel_speed", "FrontWhlSpd"),
            ("arm_rod_pressure", "Stieldruck stangenseitig"),
        ] {
            assert_eq!(
                fitting(signal, &["x", name], &[]),
                Some(1),
                "{signal} {name}"
            );
        }
        assert_eq!(
            fitting("boom_angle", &["Auslegerdruck bodenseitig"], &[]),
            None
        );
    }
}
