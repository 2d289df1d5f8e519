//! `heft weigh`: the static reference, from axle weights on level and tilted ground.

use std::path::Path;

use config::{Description, Kind};

use crate::cli::DescriptionArgs;
use crate::commands::run::description;
use crate::failure::Failure;

/// `heft weigh`
pub fn weigh(file: &Path, args: &DescriptionArgs, json: Option<&Path>) -> Result<(), Failure> {
    let Description::Loader(loader) = description(Kind::Loader, args)? else {
        return Err(Failure::internal("the loader's description is none"));
    };
    let readings = recording::csv::read_weighings(file)?;
    let readings: Vec<_> = readings
        .iter()
        .map(|&[pitch, front_load, rear_load]| estimation::loader::Weighing { pitch, front_load, rear_load })
        .collect();
    let result = estimation::loader::weigh(&readings, loader.machine.wheelbase).map_err(|e| {
        Failure::input(e, file.display(), "weigh both axles on level ground and on ground tilted by 10 degrees or more")
    })?;
    println!("{}", text(&result));
    if let Some(path) = json {
        let value = serde_json::json!({
            "mass": result.mass.value, "mass_std": result.mass.std,
            "cg_ratio": result.cg_ratio.value, "cg_ratio_std": result.cg_ratio.std,
            "cg_height": result.cg_height.map(|q| q.value), "cg_height_std": result.cg_height.map(|q| q.std),
        });
        let text = serde_json::to_string_pretty(&value).map_err(Failure::internal)?;
        std::fs::write(path, text + "\n").map_err(|e| Failure::file("write", path, &e))?;
    }
    Ok(())
}
