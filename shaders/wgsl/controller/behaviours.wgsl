// Behaviours by priority, as in Figure 3 of O'Dowd, Studley and Winfield (2014): obstacle avoidance before phototaxis
// before random search. Two genes select by the food state: gene 0 for a robot that carries food, gene 1 for one that
// does not. A gene below 0.33 flees the light, from 0.66 on seeks it, and between searches at random (Table 1). Where a world has a
// threshold of light, a robot all of whose light sensors read less searches at random, whatever the gene selects.

// What a robot does.
const FLEE_LIGHT: u32 = 0u;
const SEARCH: u32 = 1u;
const SEEK_LIGHT: u32 = 2u;
const AVOID: u32 = 3u;

// Its genes: the one for when it carries food, and the one for when it does not.
const GENE_LADEN: u32 = 0u;
const GENE_EMPTY: u32 = 1u;
const FORAGER_GENES: u32 = 2u;

// What behaviours remember.
struct Memory {
    // the side that it turns to while something is near: 1 left, -1 right, 0 none
    escape: f32,
    // cycles to go straight on after an escape
    straight: u32,
    // what is left of a random turn, in turns
    turn: f32,
    // cycles to the next random turn
    wait: u32,
}

// What it does in a cycle, why, what its sensors at the front read, and what it remembers.
struct Deed {
    wanted: Drive,
    behaviour: u32,
    front: vec4<f32>,
    memory: Memory,
}

// The behaviour that a gene selects: its hundredths in thirds.
fn selected(gene: f32) -> u32 {
    let hundredths = u32(clamp(100.0f * gene, 0.0f, 99.0f));
    return select(select(SEEK_LIGHT, SEARCH, hundredths < 66u), FLEE_LIGHT, hundredths < 33u);
}

fn behave(episode: Episode, step: u32, pose: vec3<f32>, carries: bool, before: Memory) -> Deed {
    let world = episode.world;
    let driving = driving_of(world);
    let times = times_of(world);
    var memory = before;
    var wanted = Drive(driving.cruise, 0.0f);

    // 17 and 50 degrees to the left, then 50 and 17 to the right.
    let front = near(episode, step, pose);
    let nearest = max(max(front.x, front.y), max(front.z, front.w));
    if (nearest > times.near) {
        if (memory.escape == 0.0f) {
            // Away from the stronger side; chance decides where none is.
            let stronger = (front.x + front.y) - (front.z + front.w);
            memory.escape = select(-1.0f, 1.0f, stronger < 0.0f);
            if (stronger == 0.0f) {
                let chance = random_words(episode.key, STREAM_BEHAVIOUR, step, 0u).x;
                memory.escape = select(-1.0f, 1.0f, (chance & 1u) == 0u);
            }
        }
        memory.straight = u32(times.straight);
        return Deed(Drive(0.0f, memory.escape * driving.turn), AVOID, front, memory);
    }
    memory.escape = 0.0f;
    if (memory.straight > 0u) {
        memory.straight -= 1u;
        return Deed(wanted, AVOID, front, memory);
    }

    let chosen = selected(gene(episode, select(GENE_EMPTY, GENE_LADEN, carries)));
    if (chosen != SEARCH) {
        let sought = phototaxis(episode, step, pose, chosen == FLEE_LIGHT);
        let threshold = phototaxis_of(world).threshold;
        var acts = true;
        if (threshold > 0.0f) {
            acts = sought.brightest >= threshold;
        }
        if (acts) {
            return Deed(sought.wanted, chosen, front, memory);
        }
    }

    // Straight on, and after random times turns by random angles on the spot.
    if (memory.turn == 0.0f) {
        if (memory.wait > 0u) {
            memory.wait -= 1u;
        } else {
            let words = random_words(episode.key, STREAM_BEHAVIOUR, step, 0u);
            memory.turn = 0.5f * unit(words.y) - 0.25f;
            memory.wait = u32(-times.interval * logarithm(max(unit(words.z), 0x1p-24f)));
        }
    }
    if (memory.turn != 0.0f) {
        wanted = Drive(0.0f, clamp(memory.turn, -driving.turn, driving.turn));
        memory.turn -= wanted.turn;
    }
    return Deed(wanted, SEARCH, front, memory);
}

// The way and turn of phototaxis, and the maximum reading of the light sensors.
struct Sought {
    wanted: Drive,
    brightest: f32,
}

// To where the light comes from, as all sensors have it, or away from there: the faster the straighter ahead it is.
fn phototaxis(episode: Episode, step: u32, pose: vec3<f32>, flee: bool) -> Sought {
    let driving = driving_of(episode.world);
    var ahead = 0.0f;
    var aside = 0.0f;
    var brightest = 0.0f;
    for (var half = 0u; half < 2u; half++) {
        let seen = light(episode, step, half, pose);
        brightest = max(brightest, max(max(seen.x, seen.y), max(seen.z, seen.w)));
        let along = seen * numbers(episode.world, AXES + 2u * half);
        let across = seen * numbers(episode.world, AXES + 2u * half + 1u);
        ahead += (along.x + along.y) + (along.z + along.w);
        aside += (across.x + across.y) + (across.z + across.w);
    }
    let turned = direction(vec2<f32>(ahead, aside)) + select(0.0f, 0.5f, flee);
    // From -1/2 to 1/2.
    let off = turned - floor(turned + 0.5f);
    let straight = max(cosine_sine(off).x, 0.0f);
    let turn = clamp(driving.gain * off, -driving.greatest_turn, driving.greatest_turn);
    return Sought(Drive(driving.cruise * straight, turn), brightest);
}
