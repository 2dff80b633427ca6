//! Run in a copy of the sources to which the toy was added: the parts of it that exist without further work.

use actuator_fmu::{actuator::{Actuator, Inputs, Workspace}, effects::Effects, fmu::variables::variables, parameters::{table, Model}, transition::Ramp};

fn main() -> actuator_fmu::Result<()> {
    let text = Model::from_set(&table()[0]).to_toml()?;
    let file = format!("{text}\n[effects.cube_root]\nshare = {{ value = 0.5, unit = \"1\" }}\n");
    let position = |model: &Model| -> actuator_fmu::Result<f64> {
        let actuator = Actuator::new(model.base, model.order, &model.effects);
        let mut state = actuator.at_rest(0.0);
        let inputs = Inputs::command(Ramp::held(8.0));
        actuator.step(&mut state, &mut Workspace::default(), inputs, 10.0)?;
        Ok(actuator.outputs(&state).position)
    };
    println!("parameter {}", Effects::index("cube_root", "share").is_ok());
    println!("variable {}", variables().iter().any(|variable| variable.name == "cube_root.share"));
    println!("file {:.4}", position(&Model::parse(&file)?)? - position(&Model::parse(&text)?)?);
    Ok(())
}
