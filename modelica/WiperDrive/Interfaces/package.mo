within WiperDrive;
package Interfaces "Connectors and partial models"
end Interfaces;
