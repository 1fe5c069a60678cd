/** Number with its noun in the singular or the plural. */
export const plural = (count: number, one: string, many: string): string => `${count} ${count === 1 ? one : many}`;
