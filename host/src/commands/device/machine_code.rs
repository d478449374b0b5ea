//! What a driver tells of the machine code that it makes of the kernels.

use oneiro_base::console::columns;
#[cfg(feature = "gpu")]
use oneiro_shaders::Kernel;
use serde_json::{Value, json};

/// What an adapter's driver tells of all kernels, and of that of the 1995 world; or why it doesn't.
pub(super) struct MachineCode(Result<Vec<Compiled>, String>);

/// What a driver tells of a kernel.
struct Compiled {
    kernel: String,
    /// By the driver's own names.
    statistics: Vec<(String, u64)>,
}

impl MachineCode {
    #[cfg(feature = "gpu")]
    pub(super) fn of(adapter: &oneiro::gpu::Adapter) -> Self {
        Self(compiled(adapter))
    }

    /// A table, or a line that says why there is none.
    pub(super) fn text(&self) -> String {
        let kernels = match &self.0 {
            Err(why) => return format!("  machine code: not known: {why}\n"),
            Ok(kernels) => kernels,
        };
        let names = kernels.first().map_or(&[][..], |own| &own.statistics);
        let names: Vec<&str> = names.iter().map(|(name, _)| name.as_str()).collect();
        let row = |own: &Compiled| {
            let figures = own.statistics.iter().map(|(_, value)| value.to_string());
            [vec![own.kernel.clone()], figures.collect()].concat()
        };
        let rows: Vec<Vec<String>> = kernels.iter().map(row).collect();
        format!("\n{}\n", columns(&[&["kernel"], names.as_slice()].concat(), &rows))
    }

    /// For `--json`: each kernel's statistics by its name, or `why_not`.
    pub(super) fn value(&self) -> Value {
        match &self.0 {
            Ok(kernels) => kernels
                .iter()
                .map(|own| (own.kernel.clone(), own.statistics.iter().cloned().collect::<Value>()))
                .collect(),
            Err(why) => json!({ "why_not": why }),
        }
    }
}

#[cfg(all(
    feature = "gpu",
    any(windows, target_os = "linux", target_os = "android", target_os = "freebsd")
))]
fn compiled(adapter: &oneiro::gpu::Adapter) -> Result<Vec<Compiled>, String> {
    let compiler = oneiro::gpu::Compiler::of(adapter)?;
    let mut found = Vec::new();
    let mut add = |name: String, kernel: &Kernel, spirv: &[u32]| {
        let mut statistics = compiler
            .compile(kernel, spirv)
            .map_err(|error| error.to_string())?
            .statistics;
        // Hashes tell nobody anything.
        statistics.retain(|(name, _)| !name.to_lowercase().contains("hash"));
        found.push(Compiled {
            kernel: name,
            statistics,
        });
        Ok::<_, String>(())
    };
    for kernel in oneiro_shaders::KERNELS
        .iter()
        .filter(|kernel| !kernel.name.starts_with("probe"))
    {
        add(kernel.name.into(), kernel, kernel.spirv)?;
    }
    #[cfg(feature = "compose")]
    {
        use oneiro::batch::{Batch, Rollout};
        use oneiro::world::{World, WorldSpec};

        let world = World::new(WorldSpec::miglino1995()).map_err(|error| error.to_string())?;
        let genes = vec![0.5; world.genes()];
        let rollout = Rollout {
            world: 0,
            genes: &genes,
            key: oneiro::random::Key::rollout(0, 0, 0, 0),
        };
        let batch = Batch::new(&[world], &[rollout], None).map_err(|error| error.to_string())?;
        let own = oneiro::gpu::specialised(&batch.all(), 0)?;
        add(format!("{}, world of 1995", batch.kernel().name), batch.kernel(), &own)?;
    }
    Ok(found)
}

#[cfg(all(
    feature = "gpu",
    not(any(windows, target_os = "linux", target_os = "android", target_os = "freebsd"))
))]
fn compiled(_: &oneiro::gpu::Adapter) -> Result<Vec<Compiled>, String> {
    Err("only Vulkan drivers report it".into())
}
