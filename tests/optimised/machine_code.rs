//! What real GPUs' compilers make of the kernels, without a card: Mesa's drivers compile them for cards that are not there, and their
//! machine code is read: nothing that rounds in another way is in it. That of RDNA 2 is run as well: it gives the processor's bits, and what
//! a cycle issues is pinned.
//!
//! Kernels whose `NoContraction` was taken away show that both notice fused operations.
#![cfg(all(feature = "gpu", feature = "compose", target_os = "linux"))]

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

use oneiro::gpu::{Compiled, Compiler};
use oneiro_shader_compiler::spirv;
use oneiro_shaders::{KERNELS, Kernel};

mod amd;
mod code;
mod intel;
mod lives;
mod nvidia;
mod rdna;

use crate::pinned;
use crate::pinned::Rows;
use crate::skips;
use code::Instruction;
use rdna::Code;

/// A vendor's machine code, and Mesa's driver for it.
struct Vendor {
    /// As the driver's file is called.
    driver: &'static str,
    /// The variable that says which card is there.
    variable: &'static str,
    read: fn(&str) -> Vec<Instruction<'_>>,
    figures: fn(&Compiled) -> String,
}

const AMD: Vendor = Vendor {
    driver: "radeon",
    variable: "RADV_FORCE_FAMILY",
    read: amd::read,
    figures: amd::figures,
};

const NVIDIA: Vendor = Vendor {
    driver: "nouveau",
    variable: "NOUVEAU_CHIPSET",
    read: nvidia::read,
    figures: nvidia::figures,
};

const INTEL: Vendor = Vendor {
    driver: "intel",
    variable: "INTEL_STUB_GPU_DEVICE_ID",
    read: intel::read,
    figures: intel::figures,
};

/// Cards whose machine code is alike.
struct Family {
    name: &'static str,
    vendor: Vendor,
    /// What the vendor's variable says for it.
    card: &'static str,
}

const fn family(vendor: Vendor, name: &'static str, card: &'static str) -> Family {
    Family { name, vendor, card }
}

/// What the machine's own Mesa compiles for: GCN, RDNA 1, 2 and 3.
const OWN: [Family; 4] = [
    family(AMD, "polaris10", "polaris10"),
    family(AMD, "navi10", "navi10"),
    family(AMD, "navi21", "navi21"),
    family(AMD, "gfx1100", "gfx1100"),
];

/// What Mesa 25 compiles for: RDNA 2, 3 and 4; Turing and Ampere; and Intel's Xe as part of a processor, Alchemist and Battlemage.
const UNPACKED: [Family; 8] = [
    family(AMD, "navi21", "navi21"),
    family(AMD, "navi31", "navi31"),
    family(AMD, "gfx1201", "gfx1201"),
    family(NVIDIA, "TU102", "162"),
    family(NVIDIA, "GA102", "172"),
    family(INTEL, "Tiger Lake", "0x9a49"),
    family(INTEL, "A770", "0x56a0"),
    family(INTEL, "B580", "0xe20b"),
];

/// The family whose machine code is run as well.
const RUN: &str = "navi21";

/// Names the family for a process of its own: drivers ask once.
const FAMILY: &str = "ONEIRO_FAMILY";

/// Every kernel, generic and specialised: its name, itself, and SPIR-V.
fn variants() -> Vec<(String, &'static Kernel, Vec<u32>)> {
    let generic = KERNELS
        .iter()
        .map(|kernel| (kernel.name.to_owned(), *kernel, kernel.spirv.to_vec()));
    let specialised = lives::batches().into_iter().map(|(name, batch)| {
        let spirv = oneiro::gpu::specialised(&batch.all(), 0).unwrap();
        (format!("{}, {name}", batch.kernel().name), batch.kernel(), spirv)
    });
    generic.chain(specialised).collect()
}

/// SPIR-V without its `NoContraction`.
fn contractible(words: &[u32]) -> Vec<u32> {
    let all: Vec<usize> = (0..spirv::float_arithmetic(words).len()).collect();
    spirv::without_contraction(words, &all)
}

/// Compiles everything for the family that the environment names, and prints a row for each: a process of the tests below.
#[test]
#[ignore = "the tests below run it, in a process for each family of cards, since a driver stands in for one card at a time"]
fn of_family() {
    let Ok(name) = env::var(FAMILY) else { return };
    let family = OWN.iter().chain(&UNPACKED).find(|family| family.name == name).unwrap();
    let device = Compiler::first().unwrap();
    let compiled = |kernel: &Kernel, spirv: &[u32]| device.compile(kernel, spirv).unwrap();
    let inexact = |compiled: &Compiled| {
        let code: Vec<_> = compiled.text.lines().flat_map(family.vendor.read).collect();
        assert!(code.len() > 100, "{}", compiled.text);
        assert_eq!(compiled.programs, 1, "all of the machine code is read");
        let found = code::inexact(&code);
        found.into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    println!("\ndriver {}", device.driver());
    for (kernel_name, kernel, spirv) in variants() {
        let compiled = compiled(kernel, &spirv);
        let found = inexact(&compiled);
        assert!(found.is_empty(), "{name}: {kernel_name}: {found:#?}");
        if let Some(folder) = env::var_os("ONEIRO_MACHINE_CODE") {
            let file = format!("{name}-{kernel_name}.s").replace(", ", "-").replace(' ', "-");
            std::fs::write(Path::new(&folder).join(file), &compiled.text).unwrap();
        }
        println!("row {kernel_name} | {}", (family.vendor.figures)(&compiled));
    }
    if family.name == RUN {
        for (world, batch) in lives::batches() {
            let kernel = batch.kernel();
            let own = oneiro::gpu::specialised(&batch.all(), 0).unwrap();
            for (kind, spirv) in [("any world", kernel.spirv), ("this world", &own)] {
                let code = Code::new(&compiled(kernel, spirv).text);
                assert!(
                    lives::is_exact(&batch, &code),
                    "{}, {world}, {kind}: other bits",
                    kernel.name
                );
                println!("row {}, {world}, {kind} | {}", kernel.name, lives::cost(&batch, &code));
            }
            let fused = Code::new(&compiled(kernel, &contractible(kernel.spirv)).text);
            assert!(
                !lives::is_exact(&batch, &fused),
                "{world}: fused operations have no effect"
            );
        }
    }
    // On families without fused operations at full rate the compiler makes none.
    if !["polaris10", "navi10"].contains(&family.name) {
        for kernel in KERNELS.iter().filter(|kernel| kernel.name == "life_perceptron") {
            let found = inexact(&compiled(kernel, &contractible(kernel.spirv))).len();
            assert!(found > 20, "{name}: {found} fused operations are seen");
            println!("{name}: {found} fused operations without NoContraction");
        }
    }
}

/// The machine's driver for cards of AMD.
fn driver() -> Option<PathBuf> {
    let folders = ["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d"];
    let names = ["radeon_icd.x86_64.json", "radeon_icd.json"];
    let all = folders
        .iter()
        .flat_map(|folder| names.map(|name| Path::new(folder).join(name)));
    all.into_iter().find(|path| path.exists())
}

/// Compiles everything for families, each in a process that the command begins, and compares with what is pinned.
fn look_at(families: &[Family], command: impl Fn(&Family) -> Command) {
    let mut rows = Rows::default();
    let mut version = String::new();
    let mut is_whole = true;
    for family in families {
        let ran = command(family)
            .args(["--exact", "machine_code::of_family", "--ignored", "--nocapture"])
            .env(FAMILY, family.name)
            .env(family.vendor.variable, family.card)
            .env("NODEVICE_SELECT", "1")
            .env("XDG_RUNTIME_DIR", env::temp_dir())
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&ran.stdout);
        let complained = String::from_utf8_lossy(&ran.stderr);
        if complained.contains("Unknown family") {
            println!("this Mesa has no {}", family.name);
            is_whole = false;
            continue;
        }
        assert!(ran.status.success(), "{}: {said}{complained}", family.name);
        for line in said.lines() {
            if let Some(own) = line.strip_prefix("driver Mesa ") {
                // What follows is the distribution's.
                version = own.split(['-', ' ']).next().unwrap_or_default().into();
            }
            if let Some((name, figures)) = line.strip_prefix("row ").and_then(|row| row.split_once(" | ")) {
                rows.text(family.name, name, figures);
            }
        }
    }
    assert!(!version.is_empty(), "no family was looked at");
    // Other versions of the driver make other code.
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/goldens/machine-code");
    let file = folder.join(format!("mesa-{version}.rows"));
    if is_whole && file.exists() {
        pinned::check(&file, &rows.to_string());
    } else {
        println!("no figures are kept for Mesa {version}:\n{rows}");
    }
}

#[test]
fn machine_code_is_exact_and_costs_what_is_pinned() {
    let Some(driver) = driver() else {
        skips::skipped(
            "amd-driver",
            "what AMD's cards run was not looked at (Debian: mesa-vulkan-drivers)",
        );
        return;
    };
    look_at(&OWN, |_| {
        let mut command = Command::new(env::current_exe().unwrap());
        command.env("VK_ICD_FILENAMES", &driver).env("VK_DRIVER_FILES", &driver);
        command
    });
}

#[test]
#[ignore = "needs drivers of Mesa 25, which Debian 12 does not have: tests/machine-code.sh unpacks them and runs this test, also as part of tests/long.sh"]
fn machine_code_of_other_vendors_is_exact_and_costs_what_is_pinned() {
    let mesa = env::var("ONEIRO_MESA").expect("tests/machine-code.sh says where Mesa 25 is");
    look_at(&UNPACKED, |family| {
        let mut command = Command::new(Path::new(&mesa).join("run"));
        command.arg(family.vendor.driver).arg(env::current_exe().unwrap());
        command
    });
}

#[test]
fn inexact_instructions_are_seen() {
    let division = [
        (
            &AMD,
            "v_cvt_f32_u32_e32 v1, v0\nv_rcp_f32_e32 v1, v1\nv_mul_f32_e32 v1, 0x4f7ffffe, v1 ; 10\nv_cvt_u32_f32_e32 v1, v1",
            "v_add_f32_e32 v2, v1, v1",
        ),
        (
            &NVIDIA,
            "r1 = i2f.f32.u32.re r0\nr1 = mufu.rcp r1\nr1 = fmul.ftz r1 0x4f7ffffe\nr1 = f2i.u32.f32.rz.ftz r1",
            "r2 = fadd.ftz r1 r1",
        ),
        (
            &INTEL,
            "mov(8) g2<1>F g1<0,1,0>UD\nmath inv(8) g2<1>F g2<0,1,0>F null<8,8,1>F\n\
             mul(8) g2<1>F g2<0,1,0>F 0x4f7ffffeF /* 4.29497e+09F */ { align1 };\nmov(8) g2<1>UD g2<0,1,0>F",
            "add(8) g3<1>F g2<0,1,0>F g2<0,1,0>F",
        ),
    ];
    let seen = |vendor: &Vendor, text: &str| {
        let code: Vec<_> = text.lines().flat_map(vendor.read).collect();
        code::inexact(&code).len()
    };
    for (vendor, text, other_use) in division {
        assert_eq!(seen(vendor, text), 0, "{text}");
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(seen(vendor, lines[1]), 1, "of a float: {}", lines[1]);
        let used = [lines[0], lines[1], other_use, lines[2], lines[3]].join("\n");
        assert_eq!(seen(vendor, &used), 1, "used twice: {used}");
    }
    let others = [
        (&AMD, "v_fma_f32 v1, -2.0, v0, 3.0", 0),
        (&AMD, "v_fma_f32 v1, v2, v0, 2.0", 1),
        (&AMD, "v_fmamk_f32 v1, v2, 0x40400000, v3", 1),
        (&AMD, "v_dual_mul_f32 v1, v2, v3 :: v_dual_fmac_f32 v4, v5, v6", 1),
        (&AMD, "s_fmac_f32 s1, s2, s3", 1),
        (&AMD, "v_s_rcp_f32 s1, s2", 1),
        (&AMD, "v_mad_mix_f32 v1, v2, v3, v4", 1),
        (&NVIDIA, "@!p0 r1 = ffma.ftz r2 0x40000000 r3 // delay=4", 0),
        (&NVIDIA, "@!p0 r1 = ffma.ftz r2 r3 0x40000000 // delay=4", 1),
        (&NVIDIA, "r1 = fadd.rz r2 r3", 1),
        (&NVIDIA, "r1 = mufu.ex2 r2", 1),
        (&NVIDIA, "r1 = hfma2 r2 r3 r4", 1),
        (
            &INTEL,
            "(+f0.0) mad(8) g1<1>F g2<1,1,0>F g3<1,1,0>F 0xc0000000F { align1 };",
            0,
        ),
        (
            &INTEL,
            "(+f0.0) mad(8) g1<1>F 0x40000000F g2<1,1,0>F g3<1,1,0>F { align1 };",
            1,
        ),
        (&INTEL, "mad(8) g1<1>D g2<1,1,0>D g3<1,1,0>D g4<1,1,0>W", 0),
        (&INTEL, "math sqrt(8) g1<1>F g2<1,1,0>F null<8,8,1>F", 1),
        (&INTEL, "add(8) g1<1>HF g2<1,1,0>HF g3<1,1,0>HF", 1),
    ];
    for (vendor, text, count) in others {
        assert_eq!(seen(vendor, text), count, "{text}");
    }
}
