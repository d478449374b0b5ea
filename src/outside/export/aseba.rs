//! A network as a program of a Thymio II, in Aseba's language: its numbers are whole, of 16 bits, so its outputs are near the simulator's.

use std::fmt::Write;

use super::pieces::head;
use super::plan::{Planned, plan};
use super::{Controller, Fitted, Recorded};
use crate::parameter::Invalid;
use crate::parts::network::{Activation, LayerKind};
use crate::world::differential::SensorKind;

/// What 1 is in the program, and the bits of its fractions.
const ONE: i32 = 1 << FRACTION;
const FRACTION: i32 = 10;
/// Maximum of 16 bits.
const GREATEST: i32 = i16::MAX as i32;
/// The logistic function is in a table, from 0 to 8, at so many places for each 1.
const PLACES: i32 = 4;
const LAST: i32 = 8;
/// `prox.horizontal` when the robot touches something; the maximum of a motor's target, and the speed there in mm/s, as in `thymio2.toml`.
const TOUCH: i32 = 4500;
const FASTEST: i32 = 500;
const FULL_SPEED: f32 = 166.0;
/// Its sensors of proximity.
const PROXIMITIES: usize = 7;
/// Its memory for code, words. It has 512 numbers for variables, which such code never fills.
const CODE: usize = 1534;

/// Prints a network as a program of Aseba for a Thymio II. The comment at its top says how far its outputs are from those of the recorded
/// cycles.
///
/// # Errors
/// A controller that isn't a network of dense and Elman layers, that is too large, or that reads what a Thymio II doesn't.
pub fn aseba(controller: &Controller, name: &str, origin: &[String], cycles: &[Recorded]) -> Result<Fitted, Invalid> {
    let plan = plan(controller, "aseba", &[LayerKind::Dense, LayerKind::Elman])?;
    let mut readings = String::new();
    for place in 0..controller.inputs.len() {
        readings += &reading(controller, place)?;
    }
    let described = controller.world.spec().robot.build.described();
    if let Some(speeds) = described.map(|robot| robot.speeds).filter(|speeds| *speeds > 0) {
        let problem = format!("is {speeds}; allowed for aseba: 0, any speed");
        return Err(Invalid::new("robot.speeds", problem));
    }
    if let Some(speed) = controller.full_speed.filter(|speed| *speed > FULL_SPEED) {
        let problem = format!("is {speed}; allowed for aseba: up to {FULL_SPEED}, which a Thymio II drives");
        return Err(Invalid::new("robot.greatest_speed_mm_s", problem));
    }
    let mut layers = Vec::new();
    for layer in &plan.layers {
        let before = layers.last().map_or(1.0, Layer::greatest);
        layers.push(Layer::new(layer, before)?);
    }
    let table = table();
    let words = layers.iter().map(Layer::words).sum::<usize>() + 2 * table.len() + 12 * controller.inputs.len() + 80;
    if words > CODE {
        let problem = format!("takes about {words} words of code; allowed for aseba: {CODE}, which a Thymio II has");
        return Err(Invalid::new("controller", problem));
    }
    let farthest = farthest(&layers, plan.range, cycles);
    let mut text = String::new();
    let about = [
        String::new(),
        format!(
            "Whole numbers, {ONE} for 1: in {} cycles of the simulator, the outputs",
            cycles.len()
        ),
        format!("here are at most {farthest:.4} from those there."),
    ];
    for line in head(controller, name, origin).iter().chain(&about) {
        let _ = writeln!(text, "{}", format!("# {line}").trim_end());
    }
    let full = controller
        .full_speed
        .map_or(FASTEST, |speed| (FASTEST as f32 * speed / FULL_SPEED).round() as i32);
    let (middle, span) = command(plan.range);
    let _ = writeln!(
        text,
        "
var one = {ONE}
# prox.horizontal of what is touched, and a wheel's full speed
var touch = {TOUCH}
var full = {}
var span = {span}
var sum
var value
var place
var rest
# The logistic function from 0 to {LAST}, {PLACES} places for each 1
var logistic[{}] = {}",
        full.clamp(1, FASTEST),
        table.len(),
        listed(&table)
    );
    for (index, layer) in layers.iter().enumerate() {
        text += &layer.declared(index);
    }
    let last = layers.len();
    let _ = write!(
        text,
        "var x{last}[{}]

# The logistic function of sum
sub logistic_of_sum
    place = abs(sum) >> {shift}
    rest = abs(sum) & {mask}
    value = logistic[place] + (((logistic[place + 1] - logistic[place]) * rest) >> {shift})
    if sum < 0 then
        value = {ONE} - value
    end

# From x0 to the two wheels' commands
sub cycle
",
        layers.last().map_or(0, |layer| layer.units.len()),
        shift = PLACE_BITS,
        mask = (1 << PLACE_BITS) - 1
    );
    for (index, layer) in layers.iter().enumerate() {
        text += &layer.cycle(index);
    }
    let _ = writeln!(
        text,
        "\n# Ten times a second\nonevent prox\n{readings}    callsub cycle"
    );
    for (place, side) in ["left", "right"].into_iter().enumerate() {
        let _ = writeln!(
            text,
            "    value = x{last}[{place}] - {middle}
    if value > span then
        value = span
    end
    if value < -span then
        value = -span
    end
    call math.muldiv(value, value, full, span)
    motor.{side}.target = value"
        );
    }
    let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    let file = format!(
        "<!DOCTYPE aesl-source>\n<network>\n<keywords flag=\"true\"/>\n<node nodeId=\"1\" name=\"thymio-II\">{text}</node>\n</network>\n"
    );
    let outputs =
        format!("in whole numbers, its outputs are at most {farthest:.4} from the simulator's in this episode");
    Ok(Fitted {
        bytes: file.into_bytes(),
        note: Some(outputs),
    })
}

/// The reading of the program for an input, as a statement.
fn reading(controller: &Controller, place: usize) -> Result<String, Invalid> {
    /// Directions of the sensors of proximity, degrees, and how far a sensor's may be from them.
    const DIRECTIONS: [f32; PROXIMITIES] = [40.0, 20.0, 0.0, -20.0, -40.0, 180.0, 180.0];
    const BESIDE: f32 = 5.0;
    let name = &controller.inputs[place].name;
    let refused = |problem: &str| {
        let allowed = "prox_0 to prox_6, ground_left and ground_right of `robot.preset = \"thymio2\"`";
        Invalid::new(name.clone(), format!("{problem}; allowed for aseba: {allowed}"))
    };
    let sensors = controller.world.spec().robot.described_sensors();
    let Some(sensor) = sensors.iter().find(|sensor| sensor.name == *name) else {
        return Err(refused("is no reading there"));
    };
    let turned = |degrees: f32| {
        let away = sensor.heading - degrees / 360.0;
        360.0 * (away - away.round()).abs() <= BESIDE
    };
    let number = name
        .strip_prefix("prox_")
        .and_then(|number| number.parse::<usize>().ok());
    let side = ["left", "right"]
        .iter()
        .position(|side| *name == format!("ground_{side}"));
    match (sensor.kind, number.filter(|number| *number < PROXIMITIES), side) {
        (SensorKind::Proximity, Some(number), _) if turned(DIRECTIONS[number]) => Ok(format!(
            "    call math.muldiv(x0[{place}], prox.horizontal[{number}], one, touch)\n"
        )),
        (SensorKind::Proximity, Some(_), _) => Err(refused("looks elsewhere")),
        (SensorKind::Ground, _, Some(side)) => Ok(format!("    x0[{place}] = prox.ground.delta[{side}]\n")),
        _ => Err(refused(&format!("is a {} sensor", sensor.kind.entry().name))),
    }
}

/// Bits of a number between two places of the table.
const PLACE_BITS: i32 = FRACTION - PLACES.ilog2() as i32;

/// The logistic function at the places of the table, and once more at the last.
fn table() -> Vec<i32> {
    let at = |place: i32| {
        let x = f64::from(place.min(LAST * PLACES)) / f64::from(PLACES);
        (f64::from(ONE) / (1.0 + (-x).exp())).round() as i32
    };
    (0..=LAST * PLACES + 1).map(at).collect()
}

fn logistic(sum: i32) -> i32 {
    let table = table();
    let (place, rest) = ((sum.abs() >> PLACE_BITS) as usize, sum.abs() & ((1 << PLACE_BITS) - 1));
    let value = table[place] + (((table[place + 1] - table[place]) * rest) >> PLACE_BITS);
    if sum < 0 { ONE - value } else { value }
}

/// The output that commands a standstill, and how far from it those of full speed are.
fn command(range: Activation) -> (i32, i32) {
    match range {
        Activation::Logistic | Activation::Step => (ONE / 2, ONE / 2),
        Activation::Tanh | Activation::Relu | Activation::Linear => (0, ONE),
    }
}

fn listed(numbers: &[i32]) -> String {
    let numbers: Vec<_> = numbers.iter().map(i32::to_string).collect();
    format!("[{}]", numbers.join(", "))
}

/// A layer in whole numbers.
struct Layer {
    activation: Activation,
    is_elman: bool,
    /// What it weighs: outputs of the layer before, its own of the previous cycle, and 1 if it has biases.
    sources: usize,
    has_biases: bool,
    /// The weights of each unit.
    units: Vec<Vec<i32>>,
    /// Bits that a sum of products has more than is kept of it, those that it then lacks, and its bounds before.
    shift: i32,
    lacks: i32,
    bound: i32,
}

impl Layer {
    /// `before` is the maximum output of the layer before.
    fn new(layer: &Planned, before: f32) -> Result<Self, Invalid> {
        let weights = &layer.sums[0];
        // The hyperbolic tangent of x is 2 logistic(2 x) - 1.
        let factor = layer.slope.unwrap_or(1.0) * if layer.activation == Activation::Tanh { 2.0 } else { 1.0 };
        let own = if layer.kind == LayerKind::Elman { layer.units } else { 0 };
        let greatest = greatest(layer.activation);
        let rows: Vec<Vec<f32>> = weights
            .rows
            .iter()
            .enumerate()
            .map(|(unit, row)| {
                let bias = weights.biases.as_ref().map(|biases| biases[unit]);
                row.iter().copied().chain(bias).map(|weight| factor * weight).collect()
            })
            .collect();
        let inputs = weights.rows[0].len() - own;
        let bound = |row: &Vec<f32>| -> f32 {
            let of_source = |source: usize| match source {
                source if source < inputs => before,
                source if source < inputs + own => greatest,
                _ => 1.0,
            };
            row.iter()
                .enumerate()
                .map(|(source, weight)| weight.abs() * of_source(source))
                .sum()
        };
        let largest = rows.iter().map(bound).fold(1e-3, f32::max);
        let heaviest = rows
            .iter()
            .flatten()
            .fold(1e-3_f32, |most, weight| most.max(weight.abs()));
        // A sum of products has 31 bits, what is kept of it and each weight 15.
        let bits = |most: f32| most.log2().floor() as i32;
        let kept = bits(GREATEST as f32 / largest).min(FRACTION);
        let of_weight = bits(GREATEST as f32 / heaviest)
            .min(bits(i32::MAX as f32 / (largest * ONE as f32)))
            .min(14);
        if kept < 0 || of_weight < 0 {
            let problem = format!("has sums up to {largest}; allowed for aseba: up to {GREATEST}");
            return Err(Invalid::new("controller", problem));
        }
        let whole = |weight: &f32| (weight * (1 << of_weight) as f32).round() as i32;
        let lacks = FRACTION - kept;
        // Beyond the table, the function is 0 or 1.
        let most = match layer.activation {
            Activation::Logistic | Activation::Tanh => LAST * ONE - 1,
            Activation::Relu | Activation::Linear | Activation::Step => GREATEST,
        };
        Ok(Self {
            activation: layer.activation,
            is_elman: own > 0,
            sources: rows[0].len(),
            has_biases: weights.biases.is_some(),
            units: rows.iter().map(|row| row.iter().map(whole).collect()).collect(),
            shift: of_weight + lacks,
            lacks,
            bound: most >> lacks,
        })
    }

    fn greatest(&self) -> f32 {
        greatest(self.activation)
    }

    /// Words of code that it takes, about: a small number that is set is two, another three.
    fn words(&self) -> usize {
        let set: usize = self
            .units
            .iter()
            .flatten()
            .map(|weight| if weight.abs() < 2048 { 2 } else { 3 })
            .sum();
        set + 3 * self.sources + 28 * self.units.len()
    }

    fn declared(&self, index: usize) -> String {
        let mut first = vec![0; self.sources];
        if let Some(bias) = first.last_mut().filter(|_| self.has_biases) {
            *bias = ONE;
        }
        format!(
            "# What layer {index} weighs, and the weights of its units\nvar x{index}[{}] = {}\nvar weights{index}[{}] = {}\n",
            self.sources,
            listed(&first),
            self.units.len() * self.sources,
            listed(&self.units.concat())
        )
    }

    fn cycle(&self, index: usize) -> String {
        let (next, bound) = (index + 1, self.bound);
        let mut text = String::new();
        for unit in 0..self.units.len() {
            let first = unit * self.sources;
            let last = first + self.sources - 1;
            let _ = write!(
                text,
                "    call math.dot(sum, weights{index}[{first}:{last}], x{index}, {})
    if sum > {bound} then
        sum = {bound}
    end
    if sum < -{bound} then
        sum = -{bound}
    end
",
                self.shift
            );
            if self.lacks > 0 {
                let _ = writeln!(text, "    sum = sum << {}", self.lacks);
            }
            let (before, output) = match self.activation {
                Activation::Logistic => ("    callsub logistic_of_sum\n", "value".to_owned()),
                Activation::Tanh => ("    callsub logistic_of_sum\n", format!("2 * value - {ONE}")),
                Activation::Linear => ("", "sum".to_owned()),
                Activation::Relu => ("    if sum < 0 then\n        sum = 0\n    end\n", "sum".to_owned()),
                Activation::Step => (
                    "    value = 0\n    if sum > 0 then\n        value = one\n    end\n",
                    "value".to_owned(),
                ),
            };
            let _ = writeln!(text, "{before}    x{next}[{unit}] = {output}");
        }
        for unit in (0..self.units.len()).filter(|_| self.is_elman) {
            let _ = writeln!(text, "    x{index}[{}] = x{next}[{unit}]", self.own() + unit);
        }
        text
    }

    /// Where its own outputs begin among what it weighs.
    fn own(&self) -> usize {
        self.sources - usize::from(self.has_biases) - self.units.len()
    }

    /// A cycle, as the program computes it.
    fn step(&self, x: &[i32]) -> Vec<i32> {
        let unit = |weights: &Vec<i32>| {
            let products: i32 = weights.iter().zip(x).map(|(weight, x)| weight * x).sum();
            let sum = (products >> self.shift).clamp(-self.bound, self.bound) << self.lacks;
            match self.activation {
                Activation::Logistic => logistic(sum),
                Activation::Tanh => 2 * logistic(sum) - ONE,
                Activation::Linear => sum,
                Activation::Relu => sum.max(0),
                Activation::Step => ONE * i32::from(sum > 0),
            }
        };
        self.units.iter().map(unit).collect()
    }
}

/// Maximum output of units.
fn greatest(activation: Activation) -> f32 {
    match activation {
        Activation::Logistic | Activation::Tanh | Activation::Step => 1.0,
        Activation::Relu | Activation::Linear => GREATEST as f32 / ONE as f32,
    }
}

/// The farthest that the program's outputs are from those of an episode's cycles. Its memory begins as that of the first.
fn farthest(layers: &[Layer], range: Activation, cycles: &[Recorded]) -> f32 {
    let whole = |x: &f32| (x * ONE as f32).round().clamp(-(GREATEST as f32), GREATEST as f32) as i32;
    let (middle, span) = command(range);
    let mut own: Vec<Vec<i32>> = layers
        .iter()
        .map(|layer| vec![0; if layer.is_elman { layer.units.len() } else { 0 }])
        .collect();
    let mut most = 0.0_f32;
    for cycle in cycles {
        let mut x: Vec<i32> = cycle.readings.iter().map(whole).collect();
        for (layer, own) in layers.iter().zip(&mut own) {
            x.extend(&*own);
            x.extend(layer.has_biases.then_some(ONE));
            x = layer.step(&x);
            if layer.is_elman {
                own.clone_from(&x);
            }
        }
        for (output, there) in x.iter().zip(cycle.outputs) {
            let here = 0.5 + 0.5 * (*output - middle) as f32 / span as f32;
            most = most.max((here.clamp(0.0, 1.0) - there).abs());
        }
    }
    most
}
