/** Shelf for the last state in the browser's IndexedDB. */
import type { KeptState, Shelf } from "./last_state";

const NAME = "aos-gcs";
const STORE = "last-state";
const KEY = "state";

export const databaseShelf: Shelf = {
  put: (value: KeptState) => within("readwrite", (store) => store.put(value, KEY)).then(() => undefined),
  get: () => within("readonly", (store) => store.get(KEY)),
  clear: () => within("readwrite", (store) => store.clear()).then(() => undefined),
};

/** Result of a request, once its transaction is complete: a disk that is full shows only then. */
async function within<T>(mode: IDBTransactionMode, ask: (store: IDBObjectStore) => IDBRequest<T>): Promise<T> {
  const database = await open();
  try {
    return await new Promise((resolve, reject) => {
      const transaction = database.transaction(STORE, mode);
      const request = ask(transaction.objectStore(STORE));
      transaction.oncomplete = () => resolve(request.result);
      transaction.onabort = () => reject(transaction.error ?? new Error("the browser has not stored it"));
    });
  } finally {
    database.close();
  }
}

function open(): Promise<IDBDatabase> {
  return new Promise((resolve, reject) => {
    const request = indexedDB.open(NAME, 1);
    request.onupgradeneeded = () => request.result.createObjectStore(STORE);
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error ?? new Error("the browser has no database"));
    request.onblocked = () => reject(new Error("the database is blocked by another page"));
  });
}
