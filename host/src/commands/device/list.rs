//! `oneiro device list`: this machine's devices, and whether each is exact.

use std::thread;

use oneiro::cpu::Cpu;
use oneiro_base::answer::Answer;
use oneiro_base::console::counted;
use oneiro_lab::device;
use serde_json::{Value, json};

use super::machine_code::MachineCode;

/// The CPU's lane codes, widest first, and its threads.
fn cpu() -> (Vec<&'static str>, usize) {
    let lanes = Cpu::variants()
        .into_iter()
        .filter(|name| !device::is_checked(name))
        .collect();
    (lanes, thread::available_parallelism().map_or(1, usize::from))
}

/// The CPU's instruction sets and the adapters.
pub(crate) fn answer(explains: bool) -> Answer {
    let (lanes, threads) = cpu();
    let adapters = adapters(explains);
    let mut text = format!(
        "cpu: exact; {}; lane codes, widest first: {}\n",
        counted(threads, "thread", "threads"),
        lanes.join(", ")
    );
    for adapter in &adapters {
        text += &adapter.text();
    }
    if adapters.is_empty() {
        text += if cfg!(feature = "gpu") {
            "no adapter: no Vulkan, Metal or DirectX 12 driver was found, or this program may have less than 2 GiB of memory or in a file (ulimit -v, -f)\n"
        } else {
            "no adapter: this program was built without the feature `gpu`\n"
        };
    }
    let value = json!({
        "cpu": { "lane_codes": lanes, "threads": threads, "exact": true },
        "adapters": adapters.iter().map(Adapter::value).collect::<Vec<_>>(),
    });
    Answer::new(text, value)
}

/// An adapter in the output.
struct Adapter {
    index: usize,
    name: String,
    interface: &'static str,
    driver: String,
    software: bool,
    /// Reason why it isn't exact, if it isn't.
    inexact: Option<String>,
    /// Names and values.
    limits: Vec<(&'static str, u64)>,
    float_controls: Vec<(&'static str, bool)>,
    /// What its driver tells of its machine code, if that was asked for.
    machine_code: Option<MachineCode>,
}

impl Adapter {
    fn text(&self) -> String {
        let Self {
            index,
            name,
            interface,
            driver,
            software,
            inexact,
            ..
        } = self;
        let exact = inexact
            .as_ref()
            .map_or("exact".to_owned(), |why| format!("not exact: {why}"));
        let kind = if *software {
            "software, used only when it is named"
        } else {
            "hardware"
        };
        let limits: Vec<String> = self
            .limits
            .iter()
            .map(|(name, value)| format!("{} {value}", name.replace('_', " ")))
            .collect();
        let modes: Vec<&str> = self
            .float_controls
            .iter()
            .filter(|(_, has)| *has)
            .map(|(name, _)| *name)
            .collect();
        let modes = if modes.is_empty() {
            "none".to_owned()
        } else {
            modes.join(", ").replace('_', " ")
        };
        format!(
            "gpu:{index}: {name}\n  {exact}\n  {interface}, {kind}; driver: {driver}\n  limits: {}\n  float modes: {modes}\n{}",
            limits.join(", "),
            self.machine_code.as_ref().map(MachineCode::text).unwrap_or_default(),
        )
    }

    fn value(&self) -> Value {
        let table = |rows: &[(&'static str, Value)]| -> Value {
            rows.iter()
                .map(|(name, value)| ((*name).to_owned(), value.clone()))
                .collect::<serde_json::Map<_, _>>()
                .into()
        };
        json!({
            "index": self.index,
            "name": self.name,
            "interface": self.interface,
            "driver": self.driver,
            "software": self.software,
            "exact": self.inexact.is_none(),
            "why_not_exact": self.inexact,
            "limits": table(&self.limits.iter().map(|&(name, value)| (name, value.into())).collect::<Vec<_>>()),
            "float_controls": table(&self.float_controls.iter().map(|&(name, has)| (name, has.into())).collect::<Vec<_>>()),
            "machine_code": self.machine_code.as_ref().map(MachineCode::value),
        })
    }
}

#[cfg(feature = "gpu")]
fn adapters(explains: bool) -> Vec<Adapter> {
    let all = oneiro::gpu::adapters();
    all.iter().map(|own| adapter(own, explains)).collect()
}

#[cfg(feature = "gpu")]
fn adapter(adapter: &oneiro::gpu::Adapter, explains: bool) -> Adapter {
    use oneiro::gpu::{Gpu, Path};

    let path = if adapter.takes_spirv() { Path::Spirv } else { Path::Wgsl };
    let inexact = match Gpu::open_with(adapter, path) {
        Ok(gpu) => gpu.why_inexact().map(str::to_owned),
        Err(error) => Some(error.to_string()),
    };
    let limits = adapter.limits();
    let floats = adapter.float_controls();
    Adapter {
        index: adapter.index(),
        name: adapter.name().to_owned(),
        interface: adapter.backend(),
        driver: adapter.driver(),
        software: adapter.is_software(),
        inexact,
        limits: vec![
            ("storage_buffers", limits.storage_buffers.into()),
            ("binding_bytes", limits.binding_bytes),
            ("buffer_bytes", limits.buffer_bytes),
            ("workgroups", limits.workgroups.into()),
        ],
        float_controls: vec![
            ("round_to_nearest", floats.round_to_nearest),
            ("keep_special", floats.keep_special),
            ("keep_subnormal", floats.keep_subnormal),
        ],
        machine_code: explains.then(|| MachineCode::of(adapter)),
    }
}

#[cfg(not(feature = "gpu"))]
fn adapters(_: bool) -> Vec<Adapter> {
    Vec::new()
}
