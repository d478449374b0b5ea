// A report: its list of contents and its charts.
import { followContents } from './contents.js';
import { attach } from './svg-chart.js';

followContents();
attach();
