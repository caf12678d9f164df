within WiperDrive;
package Electronics "The controller unit's hardware: what lies between motor and algorithm"
end Electronics;
