// Shipped experiments that this page can run: those without files of their own.
export const EXAMPLES = [
    'khepera-avoidance',
    'khepera-sensor-noise',
    'khepera-conservative-noise',
    'khepera-recurrent',
    'khepera-hidden',
    'odowd2014-over',
];
