//! The daemon on a robot's computer: installed, started, stopped and queried, by systemd or as a process.

use oneiro_base::exit::{Code, Failure, Result};

use super::file::{BINARY, Computers, ROBOT, Robot, STATE, Service};
use super::remote::Remote;

/// The unit, with `@NAME@` as placeholders.
const UNIT: &str = include_str!("oneiro-on-board.service");
/// Lines of a unit of the system's begin with this.
const SYSTEM: &str = "#system ";
/// Its log, below its directory.
const LOG: &str = "log.jsonl";

/// Whether a daemon runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ServiceState {
    Running,
    /// systemd starts it again in a moment.
    Starting,
    Failed,
    Stopped,
}

impl ServiceState {
    /// A word for tables.
    pub fn word(self) -> &'static str {
        match self {
            Self::Running => "running",
            Self::Starting => "starting",
            Self::Failed => "failed",
            Self::Stopped => "stopped",
        }
    }

    /// Of what `systemctl is-active` prints.
    fn of(word: &str) -> Self {
        match word {
            "active" => Self::Running,
            "activating" | "reloading" => Self::Starting,
            "failed" => Self::Failed,
            _ => Self::Stopped,
        }
    }
}

/// Name of a robot's unit.
fn unit(robot: &Robot) -> String {
    format!("oneiro-robot-{}.service", robot.number)
}

/// The text of a robot's unit. `directory` is absolute.
pub(super) fn unit_text(fleet: &Computers, robot: &Robot, directory: &str, user: &str) -> String {
    let is_system = fleet.service == Service::System;
    let lines = UNIT.lines().filter_map(|line| match line.strip_prefix(SYSTEM) {
        Some(line) => is_system.then_some(line),
        None => Some(line),
    });
    let text = lines.collect::<Vec<_>>().join("\n") + "\n";
    let target = if is_system {
        "multi-user.target"
    } else {
        "default.target"
    };
    let (_, text) = text.split_once("[Unit]").unwrap_or_default();
    format!("# Written by `oneiro fleet deploy`.\n[Unit]{text}")
        .replace("@ROBOT@", &robot.number.to_string())
        .replace("@DIRECTORY@", directory)
        .replace("@USER@", user)
        .replace("@TARGET@", target)
}

/// `systemctl` as this kind of service needs it.
fn systemctl(service: Service) -> &'static str {
    match service {
        Service::System => "sudo -n systemctl",
        // Where a login by ssh doesn't set it.
        _ => "XDG_RUNTIME_DIR=${XDG_RUNTIME_DIR:-/run/user/$(id -u)} systemctl --user",
    }
}

/// Installs the robot's unit. Returns what a person should know.
///
/// # Errors
/// Exit 4, as [`Remote::run`].
pub fn install(
    fleet: &Computers,
    robot: &Robot,
    remote: Remote<'_>,
    directory: &str,
    user: &str,
) -> Result<Vec<String>> {
    let text = unit_text(fleet, robot, directory, user);
    let (unit, systemctl) = (unit(robot), systemctl(fleet.service));
    match fleet.service {
        Service::Process => Ok(Vec::new()),
        Service::System => {
            let place = fleet.place(robot);
            remote.put(&place, &unit, "644", text.as_bytes())?;
            remote.run(&format!(
                "sudo -n install -m 644 {place}/{unit} /etc/systemd/system/{unit} && {systemctl} daemon-reload"
            ))?;
            Ok(Vec::new())
        }
        Service::User => {
            remote.put(".config/systemd/user", &unit, "644", text.as_bytes())?;
            remote.run(&format!("{systemctl} daemon-reload"))?;
            // Without it the unit ends with the user's last login, and does not start with the computer.
            let lingers =
                "loginctl enable-linger >/dev/null 2>&1; loginctl show-user \"$(id -un)\" --property=Linger || true";
            let lingers = remote.text(lingers)?;
            let warning = format!("its unit ends when {user} logs out: sudo loginctl enable-linger {user}");
            Ok(if lingers.trim() == "Linger=yes" {
                Vec::new()
            } else {
                vec![warning]
            })
        }
    }
}

/// The command that starts a daemon. It ends when the daemon is ready (as a process: when it has lived for a second).
pub fn start_command(fleet: &Computers, robot: &Robot) -> String {
    let (place, unit, systemctl) = (fleet.place(robot), unit(robot), systemctl(fleet.service));
    match fleet.service {
        Service::Process => format!(
            "cd {place} && if {}; then :; else nohup ./{BINARY} on-board {ROBOT} </dev/null >/dev/null 2>stderr & \
             echo $! >pid; sleep 1; {} || {{ tail -n 1 stderr >&2; exit 1; }}; fi",
            lives(),
            lives()
        ),
        _ => format!("{systemctl} reset-failed {unit} 2>/dev/null; {systemctl} enable --quiet --now {unit}"),
    }
}

/// The command that stops a daemon: it ends when the daemon has.
pub fn stop_command(fleet: &Computers, robot: &Robot) -> String {
    let (place, unit, systemctl) = (fleet.place(robot), unit(robot), systemctl(fleet.service));
    match fleet.service {
        Service::Process => format!(
            "cd {place} && if {}; then kill \"$(cat pid)\"; i=0; while {} && [ $i -lt 150 ]; do sleep 0.1; i=$((i+1)); done; \
             if {}; then echo it still runs after 15 s >&2; exit 1; fi; fi; rm -f pid",
            lives(),
            lives(),
            lives()
        ),
        _ => format!("{systemctl} disable --quiet --now {unit}"),
    }
}

/// Whether the file's process is running, and its number belongs to no other process since.
fn lives() -> &'static str {
    "{ [ -s pid ] && grep -aq on-board \"/proc/$(cat pid)/cmdline\" 2>/dev/null; }"
}

/// The state of a daemon, and the last line of its log.
///
/// # Errors
/// Exit 4, as [`Remote::run`].
pub fn state(fleet: &Computers, robot: &Robot, remote: Remote<'_>) -> Result<(ServiceState, Option<String>)> {
    let (place, unit, systemctl) = (fleet.place(robot), unit(robot), systemctl(fleet.service));
    let asked = match fleet.service {
        Service::Process => format!(
            "(cd {place} && if {}; then echo active; else echo inactive; fi)",
            lives()
        ),
        _ => format!("({systemctl} is-active {unit} || true)"),
    };
    let text = remote.text(&format!("{asked}; tail -n 1 {place}/{STATE}/{LOG} 2>/dev/null || true"))?;
    let mut lines = text.lines();
    let state = ServiceState::of(lines.next().unwrap_or_default().trim());
    Ok((state, lines.next().map(str::to_owned)))
}

/// Stops a daemon, and checks its log for the robot's confirmation that its wheels have stopped.
///
/// # Errors
/// Exit 4: the daemon was not stopped, or its log doesn't end with a confirmed stop.
pub fn stop(fleet: &Computers, robot: &Robot, remote: Remote<'_>) -> Result {
    remote.run(&stop_command(fleet, robot))?;
    let (_, last) = state(fleet, robot, remote)?;
    let Some(last) = last else {
        return Err(Failure::of(
            Code::Device,
            "stopped, but it has no log that says whether its wheels stand",
        ));
    };
    let line: serde_json::Value = serde_json::from_str(&last).unwrap_or_default();
    if line["event"] == "end" && line["stopped"] == true {
        Ok(())
    } else {
        Err(Failure::of(
            Code::Device,
            "stopped, but its log does not say that its wheels stand: look at the robot",
        ))
    }
}
