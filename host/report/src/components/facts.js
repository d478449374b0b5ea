// Data of the pages: what Rust writes into the element `replay`. Long lists of numbers are Base64 of little-endian integers of 16 bits,
// or of floats of 32. A test compares these keys with those of figures/episode.rs, swarm.rs and elites.rs.
import { element } from './dom.js';

/**
 * Something that a robot may do.
 * @typedef {object} Act
 * @property {string} name after "robot 3"
 * @property {string} [short] in a table
 * @property {string} colour the robot's
 * @property {string | null} front the colour of its front and rim; null: no robot that is shown does this
 */

/** @typedef {[number, number]} Place in mm */

/**
 * A shape of corners, or of a middle and a radius. A patch of floor has a grey.
 * @typedef {{ corners?: Place[], middle?: Place, radius?: number, grey?: number }} Shape
 */

/** @typedef {{ left: number, right: number, bottom: number, top: number }} Bounds in mm */

/**
 * A picture of the floor: its place in mm, and a byte for each cell, row after row from the lower left one, 255 for white.
 * @typedef {object} PictureFacts
 * @property {number} left
 * @property {number} bottom
 * @property {number} width
 * @property {number} height
 * @property {number} columns
 * @property {number} rows
 * @property {string} greys
 */

/**
 * @typedef {object} ArenaFacts
 * @property {Shape} ground
 * @property {boolean} open whether there are no walls
 * @property {number | null} floor its grey, from 0 to 1; null: the page's colour
 * @property {PictureFacts | null} picture what lies on it
 * @property {Shape[]} patches
 * @property {Shape[]} objects
 * @property {[Place, Place][]} walls
 * @property {Place[]} lamps
 */

/**
 * Poses of robots, for each line, for each robot. -32768: no position is known.
 * @typedef {object} PoseFacts
 * @property {number} body radius in mm
 * @property {number} unit of positions, mm
 * @property {string} x
 * @property {string} y
 * @property {string} heading in 1/65536 turn
 */

/**
 * What all robots of a page have.
 * @typedef {object} RobotFacts
 * @property {(number | string)[]} names
 * @property {number[]} times each line's cycle
 */

/**
 * A reading of all robots.
 * @typedef {object} Reading
 * @property {string} name
 * @property {number} low
 * @property {number} high its minimum and maximum
 * @property {number} from
 * @property {number} to ends of its bar
 * @property {boolean} whole whether it is a whole number
 */

/**
 * A sensor that is drawn; lengths in mm, angles in turns.
 * @typedef {object} Sensor
 * @property {number} reading
 * @property {number} bearing
 * @property {number} heading
 * @property {number} offset from the body's middle
 * @property {number} [range] the length of its ray
 * @property {number} [width] of an arc on the body
 */

/**
 * A part of a network that has a value: a reading, or its lines' sum, plus `shift`, then times `slope` into the function.
 * @typedef {object} NetworkNode
 * @property {string} name
 * @property {number} column
 * @property {number | null} reading
 * @property {number} shift
 * @property {number} slope
 * @property {string | null} function
 * @property {string} wheel that it commands, or nothing
 * @property {number} zero the value at which it is empty
 */

/** @typedef {{ strength: number, rule: string, rate: number }} Learns how a synapse changes; its strength is this reading */
/** @typedef {{ from: number, to: number, back: boolean, weights: number[], learns?: Learns }} NetworkLine the last weight is its width */
/** @typedef {[string, string]} Named a name, and what it means */
/** @typedef {{ kind: 'network', nodes: NetworkNode[], lines: NetworkLine[] }} NetworkFacts */
/** @typedef {{ kind: 'machine', states: Named[], arrows: [number, number, string, string][] }} MachineFacts */
/** @typedef {{ kind: 'tree', states: Named[], conditions: Named[] }} TreeFacts */

/**
 * A world of a page. All have the same number of robots, which follow each other.
 * @typedef {object} World
 * @property {number | string} name its generation, or what simulates it, or nothing
 * @property {string} colour
 */

/**
 * An episode.
 * @typedef {object} EpisodeOnly
 * @property {Act[]} acts states of all machines
 * @property {ArenaFacts} arena
 * @property {(NetworkFacts | MachineFacts | TreeFacts)[]} diagrams controllers
 * @property {number[]} diagram each robot's; empty without diagrams
 * @property {Bounds} view what is visible
 * @property {Reading[]} readings
 * @property {Sensor[]} sensors
 * @property {Act[]} plain each robot without a machine
 * @property {string} who what comes before names: robot; or generation or the, if robots of several worlds are shown in one arena
 * @property {World[]} worlds
 * @property {{ radius: number, count: number, places: string }} pucks for each line, for each world, for each puck: x and y in mm, floats
 * @property {string} fitness for each line, for each world: floats
 * @property {string} earned for each line, for each robot: floats; empty unless robots have scores
 * @property {string} state for each line, for each robot: an index of acts; empty without machines
 * @property {string} senders for each line, for each robot: a bit for each robot of its world that it hears, in words of 16
 * @property {string} values for each line, for each robot, for each reading: 1/65535 of its span
 */
/** @typedef {PoseFacts & RobotFacts & EpisodeOnly} EpisodeFacts */

/** @typedef {'over' | 'none' | 'opposite'} Light where the light is */

/**
 * Foragers.
 * @typedef {object} ForagersOnly
 * @property {Act[]} acts
 * @property {boolean} whole whether food on the floor and who heard whom are known
 * @property {number} arena radius in mm
 * @property {number} nest radius in mm
 * @property {number} food radius in mm
 * @property {number} lamp its distance from the wall, mm
 * @property {number} decay of light, 1/m
 * @property {number} range of messages, mm
 * @property {[number, Light][]} lights the cycles from which the light is there
 * @property {[number, number, number, number, [number, number, number]][][]} genes each robot's changes: cycle, S0, G0, G1 and their thirds
 * @property {string} state for each line, for each robot, from the lowest bit: 4 for what it does, 1 for whether it carries food,
 * 11 for food that it has just brought
 * @property {string} earned for each line, for each robot: tenths of fitness; 65535: unknown
 * @property {string} food_x for each line, for each item
 * @property {string} food_y
 * @property {string} heard for each line: the count of pairs, then each: the hearer in the upper byte, the robot it heard in the lower
 * @property {string} [age] for each line, for each robot that reports itself: tenths of a second since its last word
 * @property {string[]} [problems]
 * @property {string} [problem] for each line, for each robot: an index of problems
 * @property {string} [live] the script that has newer data
 * @property {number} [written] differs in each of its versions
 * @property {string | null} [end] how the experiment has ended
 */
/** @typedef {PoseFacts & RobotFacts & ForagersOnly} ForagersFacts */

/**
 * An axis of an archive of elites.
 * @typedef {object} Axis
 * @property {string} name
 * @property {number} least
 * @property {number} greatest
 * @property {number} cells
 */

/**
 * An archive of elites: poses of all episodes, one after the other.
 * @typedef {object} ElitesOnly
 * @property {ArenaFacts} arena
 * @property {Bounds} view what is visible
 * @property {Axis[]} axes
 * @property {boolean} grid whether cells are those of a grid, counted along the last axis first
 * @property {string[]} columns
 * @property {string[][]} rows each elite's values, for each column
 * @property {Place[]} centres of the elites' tiles, from the map's upper left corner, in thousandths of its sides
 * @property {number} best the fittest elite
 * @property {number[]} lengths poses of each episode
 * @property {number} every cycles between poses
 * @property {string} fitness for each pose: floats
 * @property {{ colour: string, front: string }} look the robot's colours
 */
/** @typedef {PoseFacts & ElitesOnly} ElitesFacts */

/**
 * The page's data.
 * @returns {any}
 */
export const facts = () => JSON.parse(element('replay', HTMLElement).textContent || '');

/**
 * Bytes as they were packed: little-endian, as every machine with a browser is.
 * @param {string} text
 */
export const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
