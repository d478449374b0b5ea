// A report: its list of contents, its charts, and its wide tables.
import { followContents } from './contents.js';
import { reachScrolled } from './scrolling.js';
import { attach } from './svg-chart.js';

followContents();
attach();
reachScrolled();
